//! What is known of an uploaded mesh.

use std::fmt;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use utoipa::ToSchema;

use super::Units;
use super::warnings::{MeshWarning, warnings};
use graspd_core::mesh::{MassFrom, Report};
use graspd_mesh_io::MeshFormat;

/// Names a mesh: 64 lower-case hexadecimal digits, derived from its bytes and format.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub struct MeshId(String);

impl MeshId {
    /// `None` unless `text` is written as ids are. Only such text ever becomes a file name.
    pub fn parse(text: &str) -> Option<Self> {
        let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        (text.len() == 64 && text.bytes().all(is_digit)).then(|| Self(text.to_owned()))
    }

    /// The id that a hash spells.
    pub fn of_hash(hash: &[u8; 32]) -> Self {
        Self(hash.iter().map(|byte| format!("{byte:02x}")).collect())
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for MeshId {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0)
    }
}

/// How the bytes of a mesh are to be read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshOptions {
    /// `None`: the content tells.
    pub format: Option<MeshFormat>,
    /// Unit of the coordinates once they are scaled.
    pub units: Option<Units>,
    /// What the coordinates of the file are multiplied by.
    pub scale: f64,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            format: None,
            units: None,
            scale: 1.0,
        }
    }
}

impl MeshOptions {
    /// What [`Self::scale`] may be, for messages.
    pub const SCALES: &str = "a number from 1e-9 to 1e9";

    /// Whether coordinates may be multiplied by this.
    pub fn is_scale(scale: f64) -> bool {
        (1e-9..=1e9).contains(&scale)
    }

    /// The scale that a text spells.
    pub fn scale_of(text: &str) -> Option<f64> {
        text.parse().ok().filter(|&scale| Self::is_scale(scale))
    }
}

/// Where volume and centre of mass come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MassSource {
    /// The enclosed solid at uniform density; the mesh is closed.
    Solid,
    /// The solid that the surface encloses once its holes, which are small, are closed by flat caps.
    Capped,
    /// The surface as a thin shell of uniform thickness; the mesh is open or broken.
    Surface,
}

/// What intake found in a mesh and did to it. Lengths are in the mesh's own unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MeshReport {
    /// Vertices in the file.
    pub vertices_read: usize,
    /// Triangles in the file.
    pub triangles_read: usize,
    /// Vertices after welding.
    pub vertices: usize,
    /// Triangles that are used.
    pub triangles: usize,
    /// Triangles that cannot be used because their area is zero.
    pub degenerate_triangles: usize,
    /// Triangles dropped because the same triangle is there already.
    #[serde(default)]
    pub duplicate_triangles: usize,
    /// Separate pieces of the surface.
    pub components: usize,
    /// Triangles whose winding was reversed so that all normals point the same way.
    pub flipped_triangles: usize,
    /// Edges with a triangle on one side only.
    pub border_edges: usize,
    /// Edges with more than two triangles.
    pub non_manifold_edges: usize,
    /// Closed lines along which the surface is open.
    #[serde(default)]
    pub holes: usize,
    /// Whether the surface is closed.
    pub watertight: bool,
    /// What centre of mass and volume were computed from.
    pub mass_from: MassSource,
    /// Enclosed volume, with holes capped where `mass_from` says so; absent of a shell.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<f64>,
    /// How far the volumes by the flux through the surface along x, y and z are apart, over the volume: a
    /// check that the surface is closed and consistently wound, then some 1e-15.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_error: Option<f64>,
    /// Area of the surface.
    pub area: f64,
    /// Centre of mass, in the mesh's frame.
    pub center_of_mass: [f64; 3],
    /// Lowest and highest corner of the axis-aligned bounding box.
    pub bounds: [[f64; 3]; 2],
    /// Greatest distance of a vertex from the centre of mass.
    pub bounding_radius: f64,
    /// Places where a finger may be put.
    pub candidates: usize,
    /// 95th over 5th percentile of the candidates' triangle areas; 1 is perfectly even.
    pub area_ratio: f64,
    /// What to know before a grasp of this mesh is trusted.
    #[serde(default)]
    pub warnings: Vec<MeshWarning>,
}

impl MeshReport {
    /// What is to be told of a mesh in this unit.
    pub fn new(report: &Report, units: Option<Units>) -> Self {
        let Report {
            vertices_read,
            triangles_read,
            vertices,
            triangles,
            degenerate_triangles,
            duplicate_triangles,
            components,
            flipped_triangles,
            border_edges,
            non_manifold_edges,
            holes,
            watertight,
            mass_from,
            volume,
            volume_error,
            area,
            center_of_mass,
            bounds,
            bounding_radius,
            candidates,
            area_ratio,
        } = report.clone();
        Self {
            vertices_read,
            triangles_read,
            vertices,
            triangles,
            degenerate_triangles,
            duplicate_triangles,
            components,
            flipped_triangles,
            border_edges,
            non_manifold_edges,
            holes,
            watertight,
            mass_from: match mass_from {
                MassFrom::Solid => MassSource::Solid,
                MassFrom::Capped => MassSource::Capped,
                MassFrom::Surface => MassSource::Surface,
            },
            volume,
            volume_error,
            area,
            center_of_mass: center_of_mass.coords.into(),
            bounds: bounds.map(|corner| corner.coords.into()),
            bounding_radius,
            candidates,
            area_ratio,
            warnings: warnings(report, units),
        }
    }
}

/// A mesh that the service keeps.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct MeshRecord {
    /// Derived from the bytes, the format, the unit and the scale: the same file has the same id.
    #[schema(value_type = String)]
    pub id: MeshId,
    pub format: MeshFormat,
    /// The unit of the coordinates, where the upload named it.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// What the coordinates of the file were multiplied by.
    pub scale: f64,
    /// Size of the file.
    pub bytes: u64,
    /// The name its sender gave it.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file_name: Option<String>,
    /// When it was first uploaded.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Timestamp,
    /// What intake found, as it was written then.
    #[schema(value_type = MeshReport)]
    pub report: Box<RawValue>,
}

impl MeshRecord {
    /// How its file is to be read.
    pub fn options(&self) -> MeshOptions {
        MeshOptions {
            format: Some(self.format),
            units: self.units,
            scale: self.scale,
        }
    }
}

/// One page of meshes, newest first.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct MeshPage {
    pub meshes: Vec<MeshRecord>,
    /// Where the next page starts; absent on the last one.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}
