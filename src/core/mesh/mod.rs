//! From the bytes of a file to a body that can be grasped.
//!
//! [`read`] turns bytes into a [`RawMesh`]; [`Mesh::prepare`] welds, orients and weighs it;
//! [`Mesh::candidates`] lists the places where a finger may be put.

use nalgebra::{Point3, UnitVector3};

/// A supported file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Stl,
    Obj,
    Ply,
}

/// What a file may hold at most; enforced while reading, never trusting counts in headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    pub triangles: usize,
    pub vertices: usize,
}

/// Triangles as the file has them: nothing checked beyond finite coordinates and indices in range.
#[derive(Debug, Clone, PartialEq)]
pub struct RawMesh {
    pub vertices: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

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

/// Where volume and centre of mass come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MassFrom {
    /// The enclosed solid at uniform density; the mesh is closed.
    Solid,
    /// The surface as a thin shell of uniform thickness; the mesh is open or broken.
    Surface,
}

/// What preparation found and did, in counts, lengths in the mesh's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    pub format: Option<Format>,
    pub vertices_read: usize,
    pub triangles_read: usize,
    pub vertices: usize,
    pub triangles: usize,
    /// Triangles dropped or unusable because their area is zero.
    pub degenerate_triangles: usize,
    pub components: usize,
    /// Triangles whose winding was reversed to make the orientation consistent and outward.
    pub flipped_triangles: usize,
    pub border_edges: usize,
    pub non_manifold_edges: usize,
    pub watertight: bool,
    pub mass_from: MassFrom,
    /// Enclosed volume; `None` when the mesh is not closed.
    pub volume: Option<f64>,
    pub area: f64,
    pub center_of_mass: Point3<f64>,
    pub bounds: [Point3<f64>; 2],
    /// Greatest distance of a vertex from the centre of mass.
    pub bounding_radius: f64,
    pub candidates: usize,
    /// 95th over 5th percentile of the candidates' triangle areas; 1 is perfectly even.
    pub area_ratio: f64,
}

/// A prepared body: welded, consistently oriented with outward winding, with mass properties.
#[derive(Debug, Clone)]
pub struct Mesh {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
    source: Vec<u32>,
    report: Report,
}

impl Mesh {
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// For each triangle its index in the file as uploaded.
    pub fn source(&self) -> &[u32] {
        &self.source
    }

    pub fn candidates(&self) -> Vec<Candidate> {
        Vec::new()
    }
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Greatest distance of a vertex from `point`, in the mesh's unit.
    pub fn radius_about(&self, point: &Point3<f64>) -> f64 {
        self.vertices
            .iter()
            .map(|v| (v - point).norm_squared())
            .fold(0.0, f64::max)
            .sqrt()
    }
}
