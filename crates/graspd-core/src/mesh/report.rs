//! What preparation found and did.

use nalgebra::Point3;

/// Area ratio up to which triangles pass for even; the paper's bodies are at or below 1.85.
pub const EVEN_RATIO: f64 = 4.0;

/// Where volume and centre of mass come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MassFrom {
    /// The enclosed solid at uniform density; the mesh is closed.
    Solid,
    /// The solid that the surface encloses once its holes are closed by flat caps, which are small.
    Capped,
    /// The surface as a thin shell of uniform thickness; the mesh is open or broken.
    Surface,
}

/// What preparation found and did, in counts, lengths in the mesh's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Vertices in the file; three per triangle in STL.
    pub vertices_read: usize,
    /// Triangles in the file, after polygons were cut.
    pub triangles_read: usize,
    /// Vertices after welding and without unused ones.
    pub vertices: usize,
    /// Triangles without those that welding collapsed.
    pub triangles: usize,
    /// Triangles dropped or unusable because their area is zero.
    pub degenerate_triangles: usize,
    /// Triangles dropped because the same triangle is there already.
    pub duplicate_triangles: usize,
    /// Parts of the surface that hang together over manifold edges; a cavity is a part.
    pub components: usize,
    /// Triangles whose winding was reversed to make the orientation consistent and outward.
    pub flipped_triangles: usize,
    /// Edges with one triangle.
    pub border_edges: usize,
    /// Edges with three or more triangles, or with two that no winding can make consistent.
    pub non_manifold_edges: usize,
    /// Every edge has exactly two triangles, consistently wound: no border, nothing non-manifold.
    ///
    /// A mesh that is not may still be closed, and weighed as a solid: two boxes that share an edge.
    pub watertight: bool,
    /// What `volume` and `center_of_mass` are those of.
    pub mass_from: MassFrom,
    /// Enclosed volume, with holes capped where `mass_from` says so; `None` of a shell.
    pub volume: Option<f64>,
    /// How far the volumes by the flux through the surface along x, y and z are apart, over the volume: rounding
    /// when the surface is closed and consistently wound. `None` as `volume`.
    pub volume_error: Option<f64>,
    /// Closed lines along which the surface is open.
    pub holes: usize,
    /// Area of the whole surface, cavities included.
    pub area: f64,
    /// In the file's frame; of the solid or of the shell, see `mass_from`.
    pub center_of_mass: Point3<f64>,
    /// Least and greatest corner of the axis-aligned bounding box.
    pub bounds: [Point3<f64>; 2],
    /// Greatest distance of a vertex from the centre of mass.
    pub bounding_radius: f64,
    /// Triangles that are not degenerate: the sites where a finger may be put.
    pub candidates: usize,
    /// 95th over 5th percentile of the candidates' triangle areas; 1 is perfectly even.
    pub area_ratio: f64,
}
