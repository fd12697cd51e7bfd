//! Triangles before preparation.

use nalgebra::Point3;

use super::{MeshWarning, NamedParts};

/// Greatest absolute coordinate accepted, in the mesh's unit.
///
/// Volumes are third powers and areas under a root fourth powers of lengths: up to 1e30 both stay
/// far below the largest double (1e308) even when summed over every triangle, and no body has
/// that size in any unit.
pub const MAX_COORDINATE: f64 = 1e30;

/// Triangles as a file has them, before anything is known of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawMesh {
    /// Positions in the file's frame and unit.
    pub vertices: Vec<Point3<f64>>,
    /// Vertex indices of each triangle, in the order of the file.
    pub triangles: Vec<[u32; 3]>,
    /// The named parts of the file.
    pub parts: NamedParts,
    /// What the reader of the file found that makes a grasp worth less than it seems; the report repeats it.
    pub warnings: Vec<MeshWarning>,
}

impl RawMesh {
    /// Multiplies every coordinate, as to change the unit.
    pub fn scale(&mut self, factor: f64) {
        if factor == 1.0 {
            return;
        }
        self.vertices
            .iter_mut()
            .for_each(|vertex| *vertex *= factor);
    }
}
