//! Where a finger may be put: one site per triangle, at its centroid (Rakesh et al. 2016).

use nalgebra::{Point3, UnitVector3};

use super::{Mesh, triangle};

/// A place on the surface where a finger may be put.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Position in the mesh's frame and unit.
    pub position: Point3<f64>,
    /// Unit normal pointing INTO the body.
    pub normal: UnitVector3<f64>,
    /// Index of the triangle in the file as uploaded, from 0.
    pub triangle: u32,
}

impl Mesh {
    /// One candidate per triangle that is not degenerate, in the order of the file; there are
    /// [`Report::candidates`](super::Report::candidates) of them, at least one.
    pub fn candidates(&self) -> Vec<Candidate> {
        self.triangles
            .iter()
            .zip(&self.source)
            .filter_map(|(&indices, &triangle)| {
                let corners = triangle::corners(&self.vertices, indices);
                (!triangle::is_degenerate(&corners, self.tolerance)).then(|| Candidate {
                    position: triangle::centroid(&corners),
                    normal: UnitVector3::new_normalize(-triangle::normal(&corners)),
                    triangle,
                })
            })
            .collect()
    }
}
