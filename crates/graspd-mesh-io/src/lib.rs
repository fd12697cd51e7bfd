#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

// | file | subject |
// |---|---|
// | `format.rs`, `detect.rs` | names of the formats; which one a file has, and its reader |
// | `foreign.rs` | what a file is that is no mesh |
// | `builder.rs`, `polygon.rs` | what every reader fills, within limits; polygons cut into triangles |
// | `stl/`, `obj.rs`, `ply/`, `off.rs`, `gltf/`, `threemf/`, `dae/` | the readers |
// | `instance.rs`, `xml.rs` | shapes that are placed several times; what the readers of XML share |
// | `part_names.rs`, `precision.rs` | names of the parts of a file; single precision that is too coarse |
// | `text.rs` | lines, words and numbers |
// | `write.rs` | writers |

mod builder;
mod dae;
mod detect;
mod error;
mod foreign;
mod format;
mod gltf;
mod instance;
mod obj;
mod off;
mod part_names;
mod ply;
mod polygon;
mod precision;
mod stl;
mod text;
mod threemf;
pub mod write;
mod xml;

pub use builder::Limits;
pub use error::{Place, ReadError};
pub use format::MeshFormat;

use builder::Builder;
use graspd_core::Interrupt;
use graspd_core::mesh::RawMesh;

/// Reads the triangles of a mesh file, and returns them with the format that was found.
///
/// The format is recognised by content, never by a name. `declared` is what the sender says it is: it settles doubts, and
/// to contradict the content is an error. Polygons are cut into triangles, whatever their shape. Coordinates keep the
/// file's frame and unit. Vertices are as the file has them: three for each triangle in STL, unused ones included in OBJ,
/// PLY and OFF.
///
/// Costs time and memory in proportion to the bytes, whatever they hold.
///
/// # Errors
/// [`ReadError::NotAMesh`] when the bytes are of no supported format, the others when they are of one but cannot be used;
/// each says where and what to do.
///
/// ```
/// use graspd_mesh_io::{Limits, MeshFormat, read};
///
/// let file = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
/// let (format, raw) = read(file, None, &Limits::NONE)?;
/// assert_eq!(format, MeshFormat::Obj);
/// assert_eq!(raw.triangles, [[0, 1, 2], [0, 2, 3]]);
///
/// let refused = read(b"v 0 0 0\nf 1 2 3\n", None, &Limits::NONE).unwrap_err();
/// assert_eq!(
///     refused.to_string(),
///     "the OBJ file is broken at line 2: the face names vertex 3, but the file has 1 vertices; \
///      send the whole file or export it again"
/// );
/// # Ok::<(), graspd_mesh_io::ReadError>(())
/// ```
pub fn read(
    bytes: &[u8],
    declared: Option<MeshFormat>,
    limits: &Limits,
) -> Result<(MeshFormat, RawMesh), ReadError> {
    read_interruptible(bytes, declared, limits, Interrupt::never())
}

/// The same as [`read()`]; `interrupt` is checked every few thousand vertices and triangles.
///
/// # Errors
/// Also [`ReadError::Interrupted`].
pub fn read_interruptible(
    bytes: &[u8],
    declared: Option<MeshFormat>,
    limits: &Limits,
    interrupt: Interrupt<'_>,
) -> Result<(MeshFormat, RawMesh), ReadError> {
    let reader = detect::reader(bytes, declared)?;
    let mesh = Builder::new(reader.format, limits, interrupt);
    let raw = (reader.read)(bytes, mesh)?;
    Ok((reader.format, raw))
}

#[cfg(test)]
mod tests;
