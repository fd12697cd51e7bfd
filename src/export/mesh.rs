//! A mesh as GLB, STL or PLY.

use nalgebra::Vector3;
use serde_json::{Value, json};

use super::glb::Glb;
use super::surface::Surface;
use crate::wire::Units;
use graspd_core::mesh::Mesh;
use graspd_mesh_io::write;

/// What STL and PLY files say of themselves.
const TITLE: &str = "graspd: the mesh as prepared, in its own frame and unit";

/// The colour of the body, in linear values.
const BODY: [f64; 4] = [0.72, 0.69, 0.64, 1.0];
/// A body that lies farther from the origin than this many times its size is written about its own
/// middle: single precision would round its shape otherwise.
const FAR: f64 = 100.0;

/// A format that meshes are written in.
pub struct ExportFormat {
    /// Its name in a request, and the ending of its files.
    pub name: &'static str,
    pub media_type: &'static str,
    write: MeshWriter,
}

/// Writes a mesh and its surface, in a unit where one is known.
type MeshWriter = fn(&Mesh, &Surface, Option<Units>) -> Result<Vec<u8>, serde_json::Error>;

/// All formats that meshes are written in; the first is the default.
pub static EXPORT_FORMATS: [ExportFormat; 3] = [
    ExportFormat {
        name: "glb",
        media_type: "model/gltf-binary",
        write: glb,
    },
    // Binary, single precision.
    ExportFormat {
        name: "stl",
        media_type: "model/stl",
        write: |_, surface, _| {
            let (vertices, triangles) = (&surface.vertices, &surface.triangles);
            Ok(write::stl(TITLE, vertices, triangles))
        },
    },
    // Binary, little endian, double precision.
    ExportFormat {
        name: "ply",
        media_type: "model/ply",
        write: |_, surface, _| {
            let (vertices, triangles) = (&surface.vertices, &surface.triangles);
            Ok(write::ply(TITLE, vertices, triangles, &surface.source))
        },
    },
];

impl ExportFormat {
    /// How the formats are named in messages.
    pub const NAMES: &str = "glb, stl or ply";

    /// Returns the format of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        EXPORT_FORMATS.iter().find(|format| format.name == name)
    }
}

/// Writes a prepared mesh with at most `budget` triangles: see `Surface::of`.
///
/// Coordinates are in the mesh's frame and unit. GLB is in metres: a node scales the coordinates where
/// the unit is known; nothing is rotated.
///
/// # Errors
/// None that a caller can do something about.
pub fn mesh(
    mesh: &Mesh,
    units: Option<Units>,
    format: &ExportFormat,
    budget: usize,
) -> Result<Vec<u8>, serde_json::Error> {
    (format.write)(mesh, &Surface::of(mesh, budget), units)
}

fn glb(mesh: &Mesh, body: &Surface, units: Option<Units>) -> Result<Vec<u8>, serde_json::Error> {
    let mut glb = Glb::default();
    let node = body_node(&mut glb, body);
    let root = glb.node(root(
        units,
        &[node],
        json!({
            "frame": "mesh", "units": units, "coarse": body.coarse,
            "triangles_of_the_mesh": mesh.triangles().len(),
        }),
    ));
    glb.finish(root)
}

/// Adds the node `mesh` with the surface.
pub(super) fn body_node(glb: &mut Glb, body: &Surface) -> usize {
    let [low, high] = body.bounds();
    let middle = nalgebra::center(&low, &high).coords;
    let is_far = middle.norm() > FAR * (high - low).norm();
    let origin = if is_far { middle } else { Vector3::zeros() };
    let material = glb.material("body", BODY);
    let positions = glb.positions(&body.vertices, &origin);
    let corners = glb.corners(&body.triangles);
    let numbers = glb.numbers(&body.source);
    let mesh = glb.mesh(
        "mesh",
        json!({
            "attributes": {"POSITION": positions}, "indices": corners, "material": material,
            "extras": {"triangles": numbers},
        }),
    );
    let mut node = json!({"name": "mesh", "mesh": mesh});
    if is_far {
        node["translation"] = json!(origin.as_slice());
    }
    glb.node(node)
}

/// Returns the node above all others, which scales to metres where the unit is known.
pub(super) fn root(units: Option<Units>, children: &[usize], extras: Value) -> Value {
    let mut root = json!({"name": "graspd", "children": children, "extras": extras});
    if let Some(units) = units {
        root["scale"] = json!(vec![units.meters(); 3]);
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;
    use graspd_core::mesh::solids;
    use graspd_mesh_io::{Limits, MeshFormat, read};

    fn prepared(raw: graspd_core::mesh::RawMesh) -> Mesh {
        Mesh::prepare(raw).unwrap()
    }

    #[test]
    fn what_is_written_is_read_back_as_the_same_body() {
        let torus = prepared(solids::torus(2.0, 0.5, 40, 20));
        for (format, expected) in [
            ("glb", MeshFormat::Glb),
            ("stl", MeshFormat::Stl),
            ("ply", MeshFormat::Ply),
        ] {
            let written = ExportFormat::named(format).unwrap();
            let bytes = mesh(&torus, None, written, usize::MAX).unwrap();
            let (found, raw) = read(&bytes, None, &Limits::NONE).unwrap();
            assert_eq!(found, expected);
            let again = prepared(raw);
            assert_eq!(again.triangles().len(), torus.triangles().len());
            let (a, b) = (again.report(), torus.report());
            assert!(
                (a.volume.unwrap() / b.volume.unwrap() - 1.0).abs() < 1e-6,
                "{format}"
            );
            assert!((a.center_of_mass - b.center_of_mass).norm() < 1e-6);
            if format == "ply" {
                assert_eq!(again.vertices(), torus.vertices());
            }
        }
    }

    #[test]
    fn a_unit_scales_to_metres_and_a_far_body_keeps_its_form() {
        let far = solids::moved(&solids::sphere(5.0, 40, 80), [4e6, 0.0, -1e6]);
        let far = prepared(far);
        let bytes = mesh(&far, Some(Units::Mm), &EXPORT_FORMATS[0], usize::MAX).unwrap();
        let (_, raw) = read(&bytes, None, &Limits::NONE).unwrap();
        let again = prepared(raw);
        let (a, b) = (again.report(), far.report());
        assert!((a.volume.unwrap() * 1e9 / b.volume.unwrap() - 1.0).abs() < 1e-5);
        assert!((a.center_of_mass * 1e3 - b.center_of_mass).norm() < 1e-5);
    }
}
