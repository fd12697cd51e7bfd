//! From triangles to a body that can be grasped, and questions about its surface.
//!
//! [`Mesh::prepare`] welds, orients and weighs a [`RawMesh`]; [`Mesh::candidates`] lists the places where a finger may
//! be put. [`Projector`] finds the place on the surface that is nearest to a point, [`Surface`] walks from one place
//! to another, and [`Adjacency`] says which triangles hang together.
//!
//! | file | subject |
//! |---|---|
//! | `raw.rs` | triangles as a reader hands them over |
//! | `prepare.rs` | the steps from a raw mesh to a [`Mesh`], in order |
//! | `weld.rs`, `duplicate_faces.rs` | points that are one point; triangles that are none, or there already |
//! | `edges.rs` | which triangles meet at which edge |
//! | `defects.rs` | the edges that keep the surface from being closed |
//! | `parts.rs`, `pairing.rs` | parts of the surface; what belongs together where solids touch |
//! | `orient.rs`, `loose.rs` | the winding of each part; which side of an open part is outside |
//! | `matter.rs`, `overlap/`, `probe.rs` | what bounds matter, where parts cross, touch or nest |
//! | `cover.rs` | places that are exposed, buried or enclosed |
//! | `bodies.rs`, `component.rs` | parts that make one body; one body as a mesh of its own |
//! | `tree.rs` | winding numbers, boxes and rays |
//! | `mass.rs`, `caps.rs` | volume, centre of mass, flatness; caps over holes |
//! | `report.rs`, `warnings.rs` | what preparation found and did; reasons to distrust it |
//! | `triangle.rs`, `candidate.rs` | geometry of one triangle; places for fingers |
//! | `sample.rs` | places for fingers, spread evenly |
//! | `curve.rs` | points in an order in which neighbours follow one another |
//! | `adjacency.rs` | which triangles hang together |
//! | `project.rs` | the place on the surface nearest to a point |
//! | `walk.rs` | from a place on the surface to others |
//! | `solids.rs` | small solids made by code |

mod adjacency;
mod bodies;
mod candidate;
mod caps;
mod component;
mod cover;
mod curve;
mod defects;
mod duplicate_faces;
mod edges;
mod loose;
mod mass;
mod matter;
mod named_parts;
mod orient;
mod overlap;
mod pairing;
mod parts;
mod prepare;
mod probe;
mod project;
mod raw;
mod report;
mod sample;
pub mod solids;
mod tree;
mod triangle;
mod walk;
mod warnings;
mod weld;

#[cfg(test)]
mod composite_tests;
#[cfg(test)]
mod tests;

pub use adjacency::Adjacency;
pub use candidate::{Candidate, NoCandidate};
pub use component::{Component, NoComponent};
pub(crate) use curve::along_curve;
pub use defects::DefectiveEdges;
pub use named_parts::NamedParts;
pub use prepare::PrepareError;
pub use project::{Projection, Projector, TIE_TOLERANCE};
pub use raw::{MAX_COORDINATE, RawMesh};
pub use report::{Body, EVEN_RATIO, MassSource, MeshReport, MeshWarning, WarningKind};
pub use sample::MAX_UNIFORM;
pub use walk::{MAX_CROSSINGS, Surface, SurfaceContact};
pub use weld::WELD_TOLERANCE;

use nalgebra::Point3;

/// Triangles, edges or vertices looked at between two checks of the interrupt: some milliseconds.
const BLOCK: usize = 1 << 15;

/// A prepared body: welded, consistently oriented with outward winding, with mass properties.
///
/// Coordinates keep the frame and unit of the file. Every index is in range, every vertex is
/// finite and used, and at least one triangle is a candidate.
#[derive(Debug, Clone)]
pub struct Mesh {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    source: Vec<u32>,
    tolerance: f64,
    cover: cover::Cover,
    /// For each triangle its body; empty when there is one.
    body_of: Vec<u32>,
    named_parts: NamedParts,
    /// Whether it is a component of another mesh.
    is_component: bool,
    report: MeshReport,
}

impl Mesh {
    /// Positions of the vertices, in the file's frame and unit.
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// Vertex indices of each triangle, counter-clockwise seen from outside the body.
    ///
    /// Slivers without a usable normal are kept, because they close the surface; they are no
    /// [candidates](Self::candidates).
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// For each triangle its index in the file as uploaded, after polygons were cut, from 0;
    /// ascending.
    pub fn source(&self) -> &[u32] {
        &self.source
    }

    /// Areas of the [triangles](Self::triangles), in the mesh's unit squared.
    pub fn areas(&self) -> impl Iterator<Item = f64> {
        let triangles = self.triangles.iter();
        triangles.map(|&indices| triangle::area(&triangle::corners(&self.vertices, indices)))
    }

    /// What preparation found and did.
    pub fn report(&self) -> &MeshReport {
        &self.report
    }

    /// Greatest distance of a vertex from `point`, in the mesh's unit.
    pub fn radius_about(&self, point: &Point3<f64>) -> f64 {
        mass::radius_about(&self.vertices, point)
    }
}
