//! The bodies that are measured.

use std::path::{Path, PathBuf};

use graspd_core::mesh::{Mesh, RawMesh};
use graspd_mesh_io::Limits;
use nalgebra::{Point3, Vector3};

/// The mesh that the paper's case wants, or the example that stands for it, with its file's name.
pub fn of_case(name: &str) -> (String, Mesh) {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/meshes");
    let folder = std::env::var_os("GRASPD_MESHES").map_or(own, PathBuf::from);
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("a folder of meshes")
        .map(|file| file.expect("a file").path())
        .collect();
    files.sort();
    let wanted: &[&str] = match name {
        "box" => &["box_1880", "box"],
        "knight" => &["knight_21358", "knight"],
        "bunny" => &["bunny_33352", "rabbit"],
        other => &[other],
    };
    let stem = |path: &Path| {
        path.file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let mut named = wanted
        .iter()
        .filter_map(|start| files.iter().find(|path| stem(path).starts_with(start)));
    let file = named.next().expect("the mesh of the case");
    let bytes = std::fs::read(file).expect("a readable file");
    let limits = Limits {
        triangles: 1 << 24,
        vertices: 1 << 24,
        ..Limits::NONE
    };
    let (_, raw) = graspd_mesh_io::read(&bytes, None, &limits).expect("a mesh");
    let mesh = Mesh::prepare(raw).expect("a usable mesh");
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    (name.into_owned(), mesh)
}

/// A body with bumps and without symmetry, of twelve `cells` squared even triangles: the six faces of a cube as
/// grids, blown up.
pub fn pebble(cells: u32) -> Mesh {
    let mut raw = RawMesh {
        vertices: Vec::new(),
        triangles: Vec::new(),
        ..RawMesh::default()
    };
    for face in 0..6 {
        let begin = raw.vertices.len() as u32;
        for i in 0..=cells {
            for j in 0..=cells {
                // Equal angles, not equal lengths, make the cells of a blown-up cube even.
                let [u, v] = [i, j].map(|k| {
                    ((f64::from(k) / f64::from(cells) - 0.5) * std::f64::consts::FRAC_PI_2).tan()
                });
                let side = if face % 2 == 0 { 1.0 } else { -1.0 };
                let mut at = Vector3::new(side, u * side, v);
                at.as_mut_slice().rotate_right(face / 2);
                raw.vertices.push(blown_up(&at.normalize()));
            }
        }
        for i in 0..cells {
            for j in 0..cells {
                let a = begin + i * (cells + 1) + j;
                let (b, c, d) = (a + cells + 1, a + cells + 2, a + 1);
                raw.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    Mesh::prepare(raw).expect("a usable mesh")
}

fn blown_up(at: &Vector3<f64>) -> Point3<f64> {
    let bumps =
        0.12 * (5.0 * at.x + 1.0).sin() * (4.0 * at.y).cos() + 0.08 * (7.0 * at.z + 0.5).sin();
    Point3::from(at.component_mul(&Vector3::new(1.0, 0.8, 0.65)) * (1.0 + bumps))
}
