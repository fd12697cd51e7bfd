//! Grasps of every kind on every mesh.

use std::path::PathBuf;

use graspd_core::contact::{Cone, ConeEdges, ContactModel, Friction};
use graspd_core::search::{Grasp, SearchProblem};
use graspd_core::wrench::{EdgeNorm, TorqueScale, Wrench};
use testkit::grasps::{Sampler, body, closures, population, problem};

/// Contacts, and edges and friction of their cones; frictionless without.
const CASES: [(usize, Option<(u32, f64)>); 10] = [
    (7, None),
    (8, None),
    (10, None),
    (12, None),
    (3, Some((8, 0.5))),
    (4, Some((8, 0.2))),
    (4, Some((4, 1.0))),
    (5, Some((5, 0.3))),
    (4, Some((16, 0.5))),
    (5, Some((8, 0.8))),
];

/// Torque scales: in units of the inverse radius, or as they are.
const SCALES: [(f64, bool); 8] = [
    (1.0, true),
    (1e-3, true),
    (1e-1, true),
    (1e1, true),
    (1e3, true),
    (1e-3, false),
    (1.0, false),
    (1e3, false),
];

/// Grasps taken from one mesh, case and scale at a time.
const BATCH: usize = 12;

/// Calls `see` with a label and the wrenches of `count` grasps, and a few more. The same every time.
pub fn for_each(meshes: &[PathBuf], count: usize, mut see: impl FnMut(&str, &[Wrench])) {
    let bodies: Vec<_> = meshes.iter().map(|path| (path, body(path))).collect();
    let mut sampler = Sampler::new(3);
    let mut seen = 0;
    // A stride that is coprime to the number of combinations visits all of them in a mixed order.
    let combinations = bodies.len() * CASES.len() * SCALES.len() * 2;
    let mut turn = 0_usize;
    while seen < count {
        let index = turn * 7919 % combinations;
        turn += 1;
        let (path, mesh) = &bodies[index % bodies.len()];
        let (contacts, cone) = CASES[index / bodies.len() % CASES.len()];
        let rest = index / bodies.len() / CASES.len();
        let (scale, of_radius) = SCALES[rest % SCALES.len()];
        let edge_norm = [EdgeNorm::UnitEdge, EdgeNorm::UnitNormal][rest / SCALES.len()];
        let radius = mesh.report().bounding_radius;
        let scale = if of_radius { scale / radius } else { scale };
        let problem = problem(
            mesh,
            contacts,
            model(cone),
            edge_norm,
            TorqueScale::Custom(scale),
        );
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        for (source, grasp) in grasps(&problem, &mut sampler) {
            let label = format!(
                "{name} {contacts} x {cone:?} {edge_norm:?} scale {scale:e} {source} {grasp:?}"
            );
            see(&label, &problem.wrenches(&grasp));
            seen += 1;
        }
    }
}

fn grasps(problem: &SearchProblem, sampler: &mut Sampler) -> Vec<(&'static str, Grasp)> {
    let (n, m) = (problem.len(), problem.contacts());
    let mut grasps = Vec::new();
    grasps.extend((0..BATCH / 4).map(|_| ("random", sampler.grasp(n, m))));
    grasps.extend(
        closures(problem, BATCH / 2, 20_000, sampler)
            .into_iter()
            .map(|g| ("closure", g)),
    );
    grasps.extend((0..BATCH / 4).map(|_| ("cluster", cluster(problem, sampler))));
    let people = population(problem, 1 + sampler.below(4), sampler);
    grasps.extend((0..BATCH / 2).map(|_| ("search", people[sampler.below(people.len())].clone())));
    grasps
}

/// A grasp of two patches: contacts are the neighbours of two random candidates.
fn cluster(problem: &SearchProblem, sampler: &mut Sampler) -> Grasp {
    let (n, m) = (problem.len(), problem.contacts());
    let mut grasp = Grasp::new();
    while grasp.len() < m {
        let center = problem.candidate(sampler.below(n) as u32).position;
        let distance = |i: u32| (problem.candidate(i).position - center).norm_squared();
        let mut all: Vec<u32> = (0..n as u32).filter(|i| !grasp.contains(i)).collect();
        all.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        all.truncate(m.div_ceil(2).min(m - grasp.len()));
        grasp.extend(all);
    }
    grasp
}

fn model(cone: Option<(u32, f64)>) -> ContactModel {
    let Some((edges, friction)) = cone else {
        return ContactModel::Frictionless;
    };
    ContactModel::Hard {
        friction: Friction::new(friction).expect("friction in range"),
        cone: Cone::Pyramid(ConeEdges::new(edges).expect("edges in range")),
    }
}
