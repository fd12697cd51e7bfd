//! Binary STL: 80 free bytes, a count, then 50 bytes a triangle, little-endian.
//!
//! ```text
//! bytes   0..80   anything, often a text
//!        80..84   the number of triangles
//! then for each triangle
//!         0..12   normal, ignored: the winding says it better
//!        12..48   three corners of three single-precision numbers
//!        48..50   attributes, ignored
//! ```
//!
//! There is no magic word, so a file is recognised by its length, which the count fixes to the byte.

use crate::builder::Builder;
use graspd_core::mesh::RawMesh;

use crate::{Place, ReadError};

const HEADER: usize = 84;
const RECORD: usize = 50;

/// The most bytes after the last triangle that pass for padding or a writer's own trailer.
///
/// Bounded, because four bytes that happen to make a small number would otherwise turn any large
/// binary file into an STL file.
const MAX_TRAILER: u64 = 4096;

/// The most triangles that the header of a file which was cut short may promise: 10 GB.
const MAX_PROMISED: u32 = 200_000_000;

/// The magic words of other kinds of files, which are sent under the wrong name.
const FOREIGN_MAGIC: [&[u8]; 10] = [
    b"\x89PNG",
    b"\xFF\xD8\xFF",
    b"GIF8",
    b"RIFF",
    b"glTF",
    b"%PDF",
    b"PK\x03\x04",
    b"\x1F\x8B",
    b"7z\xBC\xAF",
    b"\x7FELF",
];

/// The count in the header, and the length that a file of so many triangles has.
fn promised(bytes: &[u8]) -> Option<(u32, u64)> {
    let count = u32::from_le_bytes(*bytes.get(80..)?.first_chunk()?);
    Some((count, HEADER as u64 + RECORD as u64 * u64::from(count)))
}

/// Whether the length of the file is what its header promises.
pub(crate) fn fits(bytes: &[u8]) -> bool {
    promised(bytes).is_some_and(|(count, length)| {
        let trailer = (bytes.len() as u64).checked_sub(length);
        trailer.is_some_and(|trailer| trailer <= if count == 0 { 0 } else { MAX_TRAILER })
    })
}

/// Whether a file that is not text and does not [`fit`](fits) is nevertheless the beginning of a binary STL file.
///
/// It must promise more than it has, but nothing absurd; it must not begin as files of another kind do; and its header
/// must be a line of text, padded. A sender who `declared` STL is believed whatever the header holds.
pub(crate) fn is_cut_short(bytes: &[u8], declared: bool) -> bool {
    let printable = |b: &u8| matches!(b, b' '..=b'~' | b'\t' | b'\r' | b'\n' | 0xA0..);
    promised(bytes)
        .is_some_and(|(count, length)| count <= MAX_PROMISED && (bytes.len() as u64) < length)
        && !FOREIGN_MAGIC.iter().any(|magic| bytes.starts_with(magic))
        && (declared
            || bytes[..80]
                .iter()
                .skip_while(|b| printable(b))
                .all(|b| matches!(b, 0 | b' ')))
}

/// Reads a file that [`fits`] or [`is_cut_short`].
pub(crate) fn read(bytes: &[u8], mut mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let (count, length) = promised(bytes).unwrap_or((0, HEADER as u64));
    let body = bytes.get(HEADER..).unwrap_or_default();
    if (bytes.len() as u64) < length {
        return Err(mesh.malformed(
            Place::Byte(bytes.len()),
            format!(
                "the file is cut short: its header promises {count} triangles ({length} bytes), \
                 but only {} bytes were received, enough for {}; send the whole file",
                bytes.len(),
                body.len() / RECORD
            ),
        ));
    }
    // The bytes are there, so this reserves no more than in proportion to the file.
    mesh.reserve(3 * count as usize, count as usize);
    for (n, record) in body.chunks_exact(RECORD).take(count as usize).enumerate() {
        let (floats, _) = record.as_chunks::<4>();
        let mut corners = [0; 3];
        // The first three floats are the normal, which follows from the winding.
        for (corner, xyz) in corners.iter_mut().zip(floats[3..].chunks_exact(3)) {
            let xyz = [xyz[0], xyz[1], xyz[2]].map(|x| f64::from(f32::from_le_bytes(x)));
            *corner = mesh.vertex(xyz, Place::Triangle(n))?;
        }
        mesh.triangle(corners)?;
    }
    mesh.finish()
}
