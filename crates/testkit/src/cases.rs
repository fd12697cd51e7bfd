//! The measured cases: contact models, and wrench sets from bodies.

use std::path::{Path, PathBuf};

use graspd_core::contact::{Cone, ConeEdges, ContactModel, Friction};
use graspd_core::mesh::Mesh;
use graspd_core::search::Grasp;
use graspd_core::wrench::{EdgeNorm, TorqueScale, Wrench};

use crate::grasps::{Sampler, body, closures, population, problem};

/// A row of the tables: so many contacts of one kind.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub contacts: usize,
    /// Edges of the friction cones and friction; `None` is frictionless.
    pub cone: Option<(u32, f64)>,
}

impl Case {
    pub const fn hard(contacts: usize, edges: u32, friction: f64) -> Self {
        Self {
            contacts,
            cone: Some((edges, friction)),
        }
    }

    pub const fn frictionless(contacts: usize) -> Self {
        Self {
            contacts,
            cone: None,
        }
    }

    pub fn name(&self) -> String {
        match self.cone {
            Some((edges, friction)) => format!("{} × {edges}, μ {friction}", self.contacts),
            None => format!("{} frictionless", self.contacts),
        }
    }

    pub fn model(&self) -> ContactModel {
        let Some((edges, friction)) = self.cone else {
            return ContactModel::Frictionless;
        };
        let edges = ConeEdges::new(edges).expect("edges in range");
        ContactModel::Hard {
            friction: Friction::new(friction).expect("friction in range"),
            cone: Cone::Pyramid(edges),
        }
    }
}

/// The source of the grasps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Random grasps that are force closure.
    Closures,
    /// The children of generation 4 of a genetic search of 20, force closure or not.
    MidSearch,
    /// The children of generation 60.
    Converged,
}

impl Source {
    pub const ALL: [Self; 3] = [Self::Closures, Self::MidSearch, Self::Converged];

    pub fn name(self) -> &'static str {
        match self {
            Self::Closures => "random closures",
            Self::MidSearch => "mid-search",
            Self::Converged => "converged",
        }
    }
}

/// A mesh with a name for it.
pub struct Body {
    pub name: String,
    mesh: Mesh,
}

/// Meshes that are looked for, in this order: those of the paper, then the stand-ins of the repository.
const FILES: [(&str, &str); 3] = [
    ("knight_21358.stl", "knight.stl"),
    ("bunny_33352.ply", "rabbit.ply"),
    ("duck_8228.obj", "duck.obj"),
];

/// The folder of the meshes of the repository.
pub fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/meshes")
}

/// The bodies in the folder that the environment variable `GRASPD_MESHES` names, or else those of the
/// repository.
pub fn bodies() -> Vec<Body> {
    let given = std::env::var_os("GRASPD_MESHES").map(PathBuf::from);
    let own = examples();
    let found = FILES.map(|(paper, stand_in)| {
        let path = match &given {
            Some(folder) => folder.join(paper),
            None => own.join(stand_in),
        };
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        Body {
            name: name.into_owned(),
            mesh: body(&path),
        }
    });
    Vec::from(found)
}

impl Body {
    /// `count` wrench sets, fewer when the body yields no more. The same every time.
    pub fn sets(&self, case: &Case, source: Source, count: usize) -> Vec<Vec<Wrench>> {
        let problem = problem(
            &self.mesh,
            case.contacts,
            case.model(),
            EdgeNorm::UnitEdge,
            TorqueScale::MaxRadius,
        );
        let mut sampler = Sampler::new(1);
        let mut grasps: Vec<Grasp> = match source {
            Source::Closures => closures(&problem, count, 1_000_000, &mut sampler),
            Source::MidSearch => population(&problem, 4, &mut sampler),
            Source::Converged => population(&problem, 60, &mut sampler),
        };
        grasps.truncate(count);
        grasps.iter().map(|grasp| problem.wrenches(grasp)).collect()
    }
}
