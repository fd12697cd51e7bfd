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
    /// Separate pieces of the surface, connected over manifold edges; a cavity is a piece.
    pub components: usize,
    /// Triangles whose winding was reversed so that all normals point the same way, outward.
    pub flipped_triangles: usize,
    /// Edges with a triangle on one side only.
    pub border_edges: usize,
    /// Edges with more than two triangles, or with two that no winding can make consistent.
    pub non_manifold_edges: usize,
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
    /// Area of the whole surface, cavities included.
    pub area: f64,
    /// Centre of mass of the solid or of the shell (see `mass_from`), in the mesh's frame.
    #[cfg_attr(feature = "schema", schema(value_type = [f64; 3]))]
    pub center_of_mass: Point3<f64>,
    /// Lowest and highest corner of the axis-aligned bounding box.
    #[cfg_attr(feature = "schema", schema(value_type = [[f64; 3]; 2]))]
    pub bounds: [Point3<f64>; 2],
    /// Greatest distance of a vertex from the centre of mass.
    pub bounding_radius: f64,
    /// Triangles that are not degenerate: the places where a finger may be put.
    pub candidates: usize,
    /// 95th over 5th percentile of the candidates' triangle areas; 1 is perfectly even.
    pub area_ratio: f64,
    /// Reasons not to trust a grasp of this mesh as it is.
    #[cfg_attr(feature = "serde", serde(default))]
    pub warnings: Vec<MeshWarning>,
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
    /// The body is very small or large for its unit. Preparation, which knows no unit, never gives this one.
    Size,
}
