//! Why a file could not be read.
//!
//! The messages go to whoever sent the file, who may know nothing of its format: each says what is wrong, where, and
//! what to do.

use std::fmt;

use super::MeshFormat;
use graspd_core::Interrupted;

/// Where in a file something is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, from 1.
    Line(usize),
    /// A byte offset, from 0.
    Byte(usize),
    /// A triangle in the order of the file, after polygons are cut, from 0.
    Triangle(usize),
    /// A vertex in the order of the file, from 0.
    Vertex(usize),
    /// An entry of one of the lists of a glTF document, from 0.
    Item(&'static str, usize),
    /// The object of a 3MF file with that id.
    Object(u32),
    /// A byte offset in an unpacked entry of a 3MF file, from 0.
    Unpacked(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(n) => write!(f, "line {n}"),
            Self::Byte(n) => write!(f, "byte {n}"),
            Self::Triangle(n) => write!(f, "triangle {n} (counted from 0)"),
            Self::Vertex(n) => write!(f, "vertex {n} (counted from 0)"),
            Self::Item(list, n) => write!(f, "/{list}/{n}"),
            Self::Object(id) => write!(f, "object {id}"),
            Self::Unpacked(n) => write!(f, "byte {n} of its unpacked text"),
        }
    }
}

/// Why a file could not be read. The message says what is wrong, where, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// The content is not of a supported format.
    #[error(
        "this is not a mesh in a supported format: {why}; send an {} file",
        MeshFormat::TITLES
    )]
    NotAMesh {
        /// What speaks against it.
        why: String,
    },
    /// The format was recognised, but the file breaks its rules.
    #[error("the {format} file is broken at {at}: {what}")]
    Malformed {
        /// The format recognised.
        format: MeshFormat,
        /// Where it is wrong.
        at: Place,
        /// What is wrong and what to do.
        what: String,
    },
    /// The file holds more than [`super::Limits`] allow.
    #[error(
        "the file holds more than {limit} {what}, the most accepted here; simplify the mesh and send it again"
    )]
    TooLarge {
        /// Of what there is too much, such as `triangles`.
        what: &'static str,
        /// How many are accepted.
        limit: usize,
    },
    /// Reading was interrupted.
    #[error(
        "reading the file takes longer than is allowed here; simplify the mesh and send it again"
    )]
    Interrupted(#[from] Interrupted),
    /// The file is well formed, but has points only.
    #[error(
        "the {format} file is a point cloud: {points} points and no face; reconstruct its surface, as with Open3D or \
         MeshLab, and send that"
    )]
    PointCloud {
        /// The format recognised.
        format: MeshFormat,
        /// How many points there are.
        points: usize,
    },
    /// The file is well formed, but there is no surface in it.
    #[error("the file holds no triangles; export the surface as a triangle mesh")]
    NoTriangles,
}
