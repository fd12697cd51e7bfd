//! Records of uploaded meshes.

use std::fmt;

use jiff::Timestamp;
use serde::Serialize;
use serde_json::value::RawValue;
use utoipa::ToSchema;

use super::Units;
use graspd_core::mesh::MeshReport;
use graspd_mesh_io::MeshFormat;

/// The id of a mesh: 64 lower-case hexadecimal digits, derived from its bytes, format, unit and scale.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub struct MeshId(String);

impl MeshId {
    /// Reads an id; `None` unless `text` has that form. Only such text ever becomes a file name.
    pub fn parse(text: &str) -> Option<Self> {
        let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        (text.len() == 64 && text.bytes().all(is_digit)).then(|| Self(text.to_owned()))
    }

    /// The id with the digits of this hash.
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

/// How to read the bytes of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshOptions {
    /// Detected from the content when absent.
    pub format: Option<MeshFormat>,
    /// Unit of the scaled coordinates.
    pub units: Option<Units>,
    /// Factor by which the coordinates of the file are multiplied.
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
    /// The accepted values of [`Self::scale`], for messages.
    pub const SCALES: &str = "a number from 1e-9 to 1e9";

    /// Whether [`Self::scale`] may have this value.
    pub fn is_scale(scale: f64) -> bool {
        (1e-9..=1e9).contains(&scale)
    }

    /// Reads a scale.
    pub fn scale_of(text: &str) -> Option<f64> {
        text.parse().ok().filter(|&scale| Self::is_scale(scale))
    }
}

/// A mesh that the service keeps.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct MeshRecord {
    /// Derived from the bytes, the format, the unit and the scale; the same file has the same id.
    #[schema(value_type = String)]
    pub id: MeshId,
    pub format: MeshFormat,
    /// The unit of the coordinates, if the upload named it.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// Factor by which the coordinates of the file were multiplied.
    pub scale: f64,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// The file name that the client sent.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file_name: Option<String>,
    /// When it was first uploaded.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Timestamp,
    /// The report on the mesh, as it was written when the mesh was uploaded.
    #[schema(value_type = MeshReport)]
    pub report: Box<RawValue>,
}

impl MeshRecord {
    /// Returns how to read its file.
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
