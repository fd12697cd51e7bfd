//! Binary STL: 80 free bytes, a count, then 50 bytes a triangle, little-endian.

use crate::builder::Builder;
use graspd_core::mesh::RawMesh;

use crate::{Place, ReadError};

const HEADER: usize = 84;
const RECORD: usize = 50;

/// Bytes after the last triangle that are still taken for padding or a writer's own trailer.
///
/// Bounded, because four bytes that happen to make a small number would otherwise turn any large
/// binary file into an STL file.
const MAX_TRAILER: u64 = 4096;

/// Most triangles that the header of a file which is cut short is believed to promise: 10 GB.
const MAX_PROMISE: u32 = 200_000_000;

/// How files of other kinds begin that are sent under the wrong name.
const FOREIGN: [&[u8]; 10] = [
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

/// The count in the header and the length of the file that it asks for.
fn promise(bytes: &[u8]) -> Option<(u32, u64)> {
    let count = u32::from_le_bytes(*bytes.get(80..)?.first_chunk()?);
    Some((count, HEADER as u64 + RECORD as u64 * u64::from(count)))
}

/// Whether the length of the file is what its header promises.
pub(crate) fn fits(bytes: &[u8]) -> bool {
    promise(bytes).is_some_and(|(count, length)| {
        let trailer = (bytes.len() as u64).checked_sub(length);
        trailer.is_some_and(|trailer| trailer <= if count == 0 { 0 } else { MAX_TRAILER })
    })
}

/// Whether a file that is no text and does not [`fit`](fits) is nevertheless the beginning of a
/// binary STL file: it promises more than it has but nothing absurd, does not begin as files of
/// another kind do, and its header is a line of text, padded. A sender who `said` STL is believed
/// whatever text the header holds.
pub(crate) fn is_cut_short(bytes: &[u8], said: bool) -> bool {
    let printable = |b: &u8| matches!(b, b' '..=b'~' | b'\t' | b'\r' | b'\n' | 0xA0..);
    promise(bytes)
        .is_some_and(|(count, length)| count <= MAX_PROMISE && (bytes.len() as u64) < length)
        && !FOREIGN.iter().any(|magic| bytes.starts_with(magic))
        && (said
            || bytes[..80]
                .iter()
                .skip_while(|b| printable(b))
                .all(|b| matches!(b, 0 | b' ')))
}

/// Reads a file that [`fits`] or [`is_cut_short`].
pub(crate) fn read(bytes: &[u8], mut mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let (count, length) = promise(bytes).unwrap_or((0, HEADER as u64));
    let body = bytes.get(HEADER..).unwrap_or_default();
    if (bytes.len() as u64) < length {
        return Err(mesh.malformed(
            Place::Byte(bytes.len()),
            format!(
                "the file is cut short: its header promises {count} triangles ({length} bytes), \
                 but {} bytes came, enough for {}; send the whole file",
                bytes.len(),
                body.len() / RECORD
            ),
        ));
    }
    // There are as many bytes, so no more is reserved than a file has.
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
