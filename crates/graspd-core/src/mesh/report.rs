//! What preparation found in a mesh and did to it.

use nalgebra::Point3;

/// Area ratio up to which triangles pass for even; the paper's bodies are at or below 1.85.
pub const EVEN_RATIO: f64 = 4.0;

/// The source of volume and centre of mass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum MassSource {
    /// The enclosed solid at uniform density; the mesh is closed.
    Solid,
    /// The solid that the surface encloses once its holes, which are small, are closed by flat caps.
    Capped,
    /// The union of the enclosed solids, some of which overlap; what two of them share counts once. Holes, if there are
    /// any, are closed by flat caps.
    Union,
    /// The surface as a thin shell of uniform thickness; the mesh is open or broken.
    Surface,
}

/// The findings of the preparation of a mesh and the repairs that it made. Lengths are in the mesh's own
/// unit.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct MeshReport {
    /// Vertices in the file; three per triangle in STL.
    pub vertices_read: usize,
    /// Triangles in the file, after polygons were cut.
    pub triangles_read: usize,
    /// Vertices after welding, without unused ones.
    pub vertices: usize,
    /// Triangles that are used: those that welding did not collapse.
    pub triangles: usize,
    /// Triangles that were dropped or cannot be used because their area is zero.
    pub degenerate_triangles: usize,
    /// Triangles that were dropped because the same triangle is there already.
    #[cfg_attr(feature = "serde", serde(default))]
    pub duplicate_triangles: usize,
    /// Separate pieces of the surface, connected over edges; the wall of a cavity is a piece, and so is each of two
    /// solids that touch.
    pub components: usize,
    /// Triangles whose winding was reversed so that all normals point the same way, outward.
    pub flipped_triangles: usize,
    /// Edges with a triangle on one side only.
    pub border_edges: usize,
    /// Edges with more than two triangles, or with two that no winding can make consistent.
    pub non_manifold_edges: usize,
    /// Those of the non-manifold edges at which triangles could not be paired into closed pieces.
    #[cfg_attr(feature = "serde", serde(default))]
    pub unresolved_edges: usize,
    /// Closed pieces that have matter in common with another.
    #[cfg_attr(feature = "serde", serde(default))]
    pub overlapping_parts: usize,
    /// Whether there are too many pieces to look for those that overlap; then none is taken to do so.
    #[cfg_attr(feature = "serde", serde(default))]
    pub unexamined: bool,
    /// Triangles that are no candidates because their centroids lie in matter, such as the walls between solids that
    /// touch or overlap.
    #[cfg_attr(feature = "serde", serde(default))]
    pub buried_triangles: usize,
    /// Triangles that are no candidates because they lie in a sealed cavity, which no finger can reach.
    #[cfg_attr(feature = "serde", serde(default))]
    pub enclosed_triangles: usize,
    /// Triangles of open pieces for which nothing confirms which side is outside; their normals are taken on trust.
    #[cfg_attr(feature = "serde", serde(default))]
    pub unverified_normals: usize,
    /// Number of bodies that do not touch each other.
    #[cfg_attr(feature = "serde", serde(default = "one"))]
    pub body_count: usize,
    /// These bodies, in the order in which the file begins them; the first
    /// 100 where there are more. Empty when the mesh is one body.
    #[cfg_attr(feature = "serde", serde(default))]
    pub bodies: Vec<Body>,
    /// Closed lines along which the surface is open.
    #[cfg_attr(feature = "serde", serde(default))]
    pub holes: usize,
    /// Whether the surface is closed: every edge has exactly two triangles, consistently wound.
    ///
    /// A mesh that is not watertight may still have the mass of a solid, such as two boxes that share an edge.
    pub watertight: bool,
    /// What centre of mass and volume were computed from.
    pub mass_from: MassSource,
    /// Enclosed volume, with holes capped where `mass_from` says so; absent for a shell.
    #[cfg_attr(feature = "schema", schema(nullable = false))]
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub volume: Option<f64>,
    /// Greatest difference between the volumes by the flux through the surface along x, y and z and the
    /// volume, relative to the volume: about 1e-15 when the surface is closed and consistently wound.
    #[cfg_attr(feature = "schema", schema(nullable = false))]
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub volume_error: Option<f64>,
    /// Greatest error of the volume, relative to it, that cutting out the union of solids may have caused; absent
    /// unless `mass_from` is `union`.
    #[cfg_attr(feature = "schema", schema(nullable = false))]
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub volume_bound: Option<f64>,
    /// The same for the distance of the centre of mass from the right one, in the mesh's unit.
    #[cfg_attr(feature = "schema", schema(nullable = false))]
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub center_bound: Option<f64>,
    /// Area of the whole surface, with walls of cavities and with what is buried in matter.
    pub area: f64,
    /// Centre of mass of the solid or of the shell (see `mass_from`), in the mesh's frame.
    #[cfg_attr(feature = "schema", schema(value_type = [f64; 3]))]
    pub center_of_mass: Point3<f64>,
    /// Lowest and highest corner of the axis-aligned bounding box.
    #[cfg_attr(feature = "schema", schema(value_type = [[f64; 3]; 2]))]
    pub bounds: [Point3<f64>; 2],
    /// Greatest distance of a vertex from the centre of mass.
    pub bounding_radius: f64,
    /// Triangles that are not degenerate, buried or enclosed: the places where a finger may be put.
    pub candidates: usize,
    /// 95th over 5th percentile of the candidates' triangle areas; 1 is perfectly even.
    pub area_ratio: f64,
    /// Reasons not to trust a grasp of this mesh as it is.
    #[cfg_attr(feature = "serde", serde(default))]
    pub warnings: Vec<MeshWarning>,
}

/// Reports of earlier versions have no such number.
#[cfg(feature = "serde")]
fn one() -> usize {
    1
}

/// One of several bodies in a mesh that do not touch each other.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Body {
    /// The names that its triangles have in the file; the first ten where there are more.
    #[cfg_attr(feature = "serde", serde(default))]
    pub names: Vec<String>,
    pub triangles: usize,
    /// Lowest and highest corner of its axis-aligned bounding box.
    #[cfg_attr(feature = "schema", schema(value_type = [[f64; 3]; 2]))]
    pub bounds: [Point3<f64>; 2],
}

/// A property of a mesh that may make a grasp of it worth less than it seems.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct MeshWarning {
    pub kind: WarningKind,
    /// What was found and what to do.
    pub detail: String,
}

/// The subject of a warning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum WarningKind {
    /// The surface has holes.
    Open,
    /// Three or more triangles meet at an edge, or the surface has one side only.
    NonManifold,
    /// The centre of mass is not that of a closed solid.
    Mass,
    /// Triangles differ much in size.
    UnevenTriangles,
    /// The same triangle came more than once.
    Duplicates,
    /// Triangles have no area.
    Degenerate,
    /// Bytes of the file were passed over.
    File,
    /// The numbers of the file are too coarse for the size of the body.
    Precision,
    /// Solids overlap or touch, so that some of the surface is buried.
    Overlap,
    /// Some of the surface is sealed off.
    Enclosed,
    /// There are several bodies that do not touch.
    SeveralBodies,
    /// Nothing confirms which side of some faces is outside.
    UnverifiedNormals,
    /// The body is very small or large for its unit. Preparation, which knows no unit, never gives this one.
    Size,
}
