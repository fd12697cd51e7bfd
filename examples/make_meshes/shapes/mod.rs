//! The four bodies. x points forward, y to the left, z up; each body stands near z = 0.

pub mod cuboid;
pub mod duck;
pub mod knight;
pub mod rabbit;

use crate::{mesh::Mesh, remesh::remesh, sdf::Field, surface::extract};
use fast_surface_nets::glam::DVec3;

/// A body given by its distance field, inside the box from `min` to `max`.
pub struct Body {
    pub field: Box<Field>,
    pub min: DVec3,
    pub max: DVec3,
    /// Side of the grid's cubes for the extraction; fine enough for the thinnest part.
    pub step: f64,
    pub triangles: usize,
}

impl Body {
    pub fn mesh(&self) -> Result<Mesh, String> {
        let rough = extract(&self.field, self.min, self.max, self.step);
        if rough.check()?.genus != 0 {
            return Err("the grid is too coarse: it closes a gap into a handle".to_owned());
        }
        remesh(&self.field, &rough, self.triangles)
    }
}
