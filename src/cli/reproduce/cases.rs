//! The experiments of Rakesh et al. (2016), §4, with the results of the paper.

use std::borrow::Cow;
use std::io;
use std::path::Path;

use serde_json::{Value, json};

/// A row of the paper's table.
pub struct Case {
    pub name: &'static str,
    /// Prefix of the name of the mesh file.
    pub mesh: &'static str,
    pub contacts: u32,
    pub friction: bool,
    pub population: u32,
    pub generations: u32,
    /// Initial and final quality in the paper, on its own meshes and torque scale.
    pub paper: [f64; 2],
    /// Whether the paper also varies population and generations.
    pub grid: bool,
}

const fn case(
    name: &'static str,
    mesh: &'static str,
    friction: bool,
    size: [u32; 2],
    paper: [f64; 2],
    grid: bool,
) -> Case {
    Case {
        name,
        mesh,
        contacts: if friction { 4 } else { 7 },
        friction,
        population: size[0],
        generations: size[1],
        paper,
        grid,
    }
}

/// The five cases.
pub const CASES: [Case; 5] = [
    case("box-7", "box", false, [400, 30], [0.017, 0.200], true),
    case("knight-7", "knight", false, [200, 20], [0.057, 0.126], true),
    case("knight-4", "knight", true, [200, 20], [0.065, 0.146], true),
    case("bunny-4", "bunny", true, [200, 20], [0.072, 0.197], false),
    case("duck-4", "duck", true, [200, 20], [0.086, 0.186], false),
];

/// Populations and generations of the grids (Figs. 8, 10 and 12).
pub const POPULATIONS: [u32; 4] = [50, 100, 200, 400];
pub const GENERATIONS: [u32; 3] = [10, 20, 30];

/// All methods; the first is that of the paper.
pub const METHODS: [&str; 4] = ["modified_ga", "local", "random", "memetic"];

impl Case {
    /// The request of one run. All methods have the number of evaluations that the genetic algorithm makes with this
    /// population and these generations; contacts stay at centroids.
    pub fn request(&self, method: &str, population: u32, generations: u32, seed: u64) -> Value {
        let mut request = json!({
            "contacts": self.contacts,
            "method": method,
            "initial": "strict",
            "polish": false,
            "evaluation_limit": population * (generations + 1),
            "seed": seed,
        });
        if self.friction {
            request["friction"] = json!(0.2);
            request["cone_edges"] = json!(8);
        } else {
            request["contact_model"] = json!("frictionless");
        }
        match method {
            "memetic" => request["generations"] = json!(100_000),
            _ => {
                request["population"] = json!(population);
                request["generations"] = json!(generations);
            }
        }
        if method == "modified_ga" {
            // The limit also counts the evaluations of the first grasp, which must not cut the run short.
            request["evaluation_limit"] = json!(2 * population * (generations + 1));
        }
        request
    }

    /// Returns the name and bytes of the mesh: from a folder, or the bundled one.
    pub fn file(&self, folder: Option<&Path>) -> io::Result<(String, Cow<'static, [u8]>)> {
        let Some(folder) = folder else {
            let (name, bytes): (&str, &'static [u8]) = match self.mesh {
                "box" => (
                    "box.stl",
                    include_bytes!("../../../examples/meshes/box.stl"),
                ),
                "knight" => (
                    "knight.stl",
                    include_bytes!("../../../examples/meshes/knight.stl"),
                ),
                "bunny" => (
                    "rabbit.ply",
                    include_bytes!("../../../examples/meshes/rabbit.ply"),
                ),
                _ => (
                    "duck.obj",
                    include_bytes!("../../../examples/meshes/duck.obj"),
                ),
            };
            return Ok((name.to_owned(), Cow::Borrowed(bytes)));
        };
        let mut names = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            let stands_in = self.mesh == "bunny" && name.starts_with("rabbit");
            if name.starts_with(self.mesh) || stands_in {
                names.push(name);
            }
        }
        names.sort();
        let name = names.into_iter().next().ok_or_else(|| {
            io::Error::other(format!(
                "no file in {} starts with {:?}",
                folder.display(),
                self.mesh
            ))
        })?;
        let bytes = std::fs::read(folder.join(&name))?;
        Ok((name, Cow::Owned(bytes)))
    }
}
