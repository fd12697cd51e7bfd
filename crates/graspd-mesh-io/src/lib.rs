//! From the bytes of a file to triangles: STL, OBJ, PLY, OFF, GLB and glTF.
//!
//! Nothing in a file is trusted. A count in a header is compared with the bytes that are there
//! before anything is reserved for it, every index is checked, and no reader opens a second file.
//! The readers are our own because the kept crates fall short on bad or odd input: of a
//! multi-solid ASCII STL `stl_io` reads the first solid and it takes every header that starts
//! with `solid` for ASCII, `tobj` reads single precision, names no line and overflows on extreme
//! texture indices, and PLY crates allocate whatever the header asks for.

#![forbid(unsafe_code)]

mod builder;
mod detect;
mod error;
mod format;
mod gltf;
mod obj;
mod off;
mod ply;
mod polygon;
mod stl;
mod text;

pub use builder::Limits;
pub use format::MeshFormat;
use graspd_core::Interrupt;
use graspd_core::mesh::RawMesh;

use builder::Builder;
pub use error::{Place, ReadError};

/// Reads the triangles of a mesh file.
///
/// The format is recognised by content, never by a name; `format` is what the sender says it is,
/// and a sender who contradicts the content is told so. Polygons are cut into triangles, whatever their
/// shape. Coordinates keep the file's frame and unit. Vertices are as the file
/// has them: three per triangle in STL, unused ones included in OBJ and PLY.
///
/// Costs time and memory in proportion to the bytes, whatever they hold.
///
/// # Errors
/// [`ReadError::NotAMesh`] when the bytes are of no supported format, the others when they are
/// of one but cannot be used; each says where and what to do.
pub fn read(
    bytes: &[u8],
    format: Option<MeshFormat>,
    limits: &Limits,
) -> Result<(MeshFormat, RawMesh), ReadError> {
    read_interruptible(bytes, format, limits, Interrupt::never())
}

/// As [`read()`], but `interrupt` is checked every few thousand vertices and triangles.
///
/// # Errors
/// Also [`ReadError::Interrupted`].
pub fn read_interruptible(
    bytes: &[u8],
    format: Option<MeshFormat>,
    limits: &Limits,
    interrupt: Interrupt<'_>,
) -> Result<(MeshFormat, RawMesh), ReadError> {
    let reader = detect::reader(bytes, format)?;
    let mesh = Builder::new(reader.format, limits, interrupt);
    let raw = (reader.read)(bytes, mesh)?;
    Ok((reader.format, raw))
}

#[cfg(test)]
mod tests;
