//! Shapes that a file describes once and places several times, as 3MF and COLLADA do.

use nalgebra::{Affine3, Matrix4, Point3};

use crate::builder::Builder;
use crate::{Place, ReadError};

/// The most places where the shapes of a file may be put, and the most nodes on the way to them. Nodes that refer to each
/// other could otherwise make a small file endless.
pub(super) const MAX_INSTANCES: usize = 1 << 16;

/// Vertices and faces in a frame of their own.
#[derive(Default)]
pub(super) struct Shape {
    pub(super) vertices: Vec<Point3<f64>>,
    /// The corners of all faces, one face behind the other.
    pub(super) corners: Vec<u32>,
    /// How many corners each face has; `None` where all are triangles.
    pub(super) sizes: Option<Vec<u32>>,
}

impl Shape {
    /// Returns the bytes of memory that the shape takes.
    pub(super) fn memory(&self) -> usize {
        let corners = self.corners.capacity() + self.sizes.as_ref().map_or(0, Vec::capacity);
        self.vertices.capacity() * size_of::<Point3<f64>>() + corners * size_of::<u32>()
    }

    /// Adds the shape to the mesh, moved from its own frame by `frame`; `at` is where the file describes it. A frame that
    /// mirrors turns the faces over.
    pub(super) fn place(
        &self,
        frame: &Matrix4<f64>,
        at: Place,
        mesh: &mut Builder<'_>,
    ) -> Result<(), ReadError> {
        if self.corners.is_empty() {
            return Ok(());
        }
        let count = self.vertices.len();
        if let Some(index) = self.corners.iter().find(|&&index| index as usize >= count) {
            let what = format!(
                "a face names vertex {index} (counted from 0), but there are {count}; export the mesh again"
            );
            return Err(mesh.malformed(at, what));
        }
        let first = mesh.vertices() as u32;
        let is_mirrored = frame.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        let frame = Affine3::from_matrix_unchecked(*frame);
        for vertex in &self.vertices {
            let moved = frame.transform_point(vertex);
            mesh.vertex([moved.x, moved.y, moved.z], at)?;
        }
        let mut face = Vec::new();
        let mut add = |corners: &[u32]| {
            face.clear();
            face.extend(corners.iter().map(|corner| first + corner));
            if is_mirrored {
                face.reverse();
            }
            mesh.polygon(&face, at)
        };
        let Some(sizes) = &self.sizes else {
            let (triangles, _) = self.corners.as_chunks::<3>();
            return triangles.iter().try_for_each(|corners| add(corners));
        };
        let mut rest = &self.corners[..];
        for &size in sizes {
            let (corners, behind) = rest.split_at((size as usize).min(rest.len()));
            add(corners)?;
            rest = behind;
        }
        Ok(())
    }
}
