//! Binary STL: 80 free bytes, a count, then 50 bytes a triangle, little-endian.
//!
//! ```text
//! bytes   0..80   anything, often a text
//!        80..84   the number of triangles
//! then for each triangle
//!         0..12   normal, ignored: the winding says it better
//!        12..48   three corners of three single-precision numbers
//!        48..50   attributes: a colour, or the number of bytes that follow before the next triangle
//! ```
//!
//! There is no magic word, so a file is recognised by its length, which the count fixes to the byte. Three kinds of
//! files are longer than the count of their header says, and [`Layout::of`] tries them in this order:
//!
//! 1. Several solids, one behind the other, each with a header of its own.
//! 2. The attributes of each triangle announce bytes that follow it, and with them the length is right to the byte.
//! 3. A trailer of the program that wrote the file, at most [`MAX_TRAILER`] bytes.
//!
//! **Cost:** the first test looks at one header for each solid, the second at one record for each triangle.

use graspd_core::mesh::{RawMesh, WarningKind};

use crate::builder::Builder;
use crate::foreign;
use crate::{Place, ReadError};

const HEADER: usize = 84;
const RECORD: usize = 50;

/// The most bytes after the last triangle that pass for padding or a writer's own trailer.
///
/// Bounded, because four bytes that happen to make a small number would otherwise turn any large
/// binary file into an STL file.
const MAX_TRAILER: usize = 4096;

/// The most triangles that the header of a file which was cut short may promise: 10 GB.
const MAX_PROMISED: u32 = 200_000_000;

/// The count in a header, and the length of a solid with so many triangles.
fn promised(bytes: &[u8]) -> Option<(u32, u64)> {
    let count = u32::from_le_bytes(*bytes.get(80..)?.first_chunk()?);
    Some((count, HEADER as u64 + RECORD as u64 * u64::from(count)))
}

/// How the bytes after the first header are laid out.
#[derive(Debug, PartialEq, Eq)]
enum Layout {
    /// So many solids, then so many bytes that belong to none.
    Solids { solids: usize, trailer: usize },
    /// One solid, whose triangles are followed by as many bytes as their attributes say.
    Payload,
}

impl Layout {
    /// Returns the layout of a file that is at least as long as its header promises.
    fn of(bytes: &[u8]) -> Option<Self> {
        let mut solids = 0;
        let mut rest = bytes;
        while let Some((count, length)) = promised(rest)
            && (count > 0 || solids == 0)
            && let Some(behind) = rest.get(usize::try_from(length).unwrap_or(usize::MAX)..)
        {
            solids += 1;
            rest = behind;
        }
        match (solids, rest.len()) {
            (0, _) => None,
            (1, 1..) if has_payload(bytes) => Some(Self::Payload),
            (solids, trailer) => Some(Self::Solids { solids, trailer }),
        }
    }
}

/// Whether the first solid ends with the file if its triangles have as many more bytes as their attributes announce.
fn has_payload(bytes: &[u8]) -> bool {
    let Some((count, _)) = promised(bytes) else {
        return false;
    };
    let mut rest = &bytes[HEADER..];
    for _ in 0..count {
        match split_record(rest) {
            Some((_, _, behind)) => rest = behind,
            None => return false,
        }
    }
    rest.is_empty()
}

/// Takes a triangle and its payload: the record, the length of the payload, and the bytes behind it.
fn split_record(bytes: &[u8]) -> Option<(&[u8], usize, &[u8])> {
    let (record, behind) = bytes.split_at_checked(RECORD)?;
    let payload = usize::from(u16::from_le_bytes([record[RECORD - 2], record[RECORD - 1]]));
    Some((record, payload, behind.get(payload..)?))
}

/// Whether the length of the file is what its headers promise.
pub(crate) fn fits(bytes: &[u8]) -> bool {
    let Some((count, _)) = promised(bytes) else {
        return false;
    };
    match Layout::of(bytes) {
        Some(Layout::Payload) => true,
        Some(Layout::Solids { trailer: 0, .. }) => true,
        Some(Layout::Solids { trailer, .. }) => {
            count > 0 && (trailer <= MAX_TRAILER || begins_solid(&bytes[bytes.len() - trailer..]))
        }
        None => false,
    }
}

/// Whether the bytes behind a solid are the beginning of one more. A count of 2²⁴ or more is taken for text.
fn begins_solid(rest: &[u8]) -> bool {
    is_cut_short(rest, false) && promised(rest).is_some_and(|(count, _)| count < 1 << 24)
}

/// Whether a file that is not text and does not [`fit`](fits) is nevertheless the beginning of a binary STL file.
///
/// It must promise more than it has, but nothing absurd; it must not begin as files of another kind do; and its header
/// must be a line of text, padded. A sender who `declared` STL is believed whatever the header holds.
pub(crate) fn is_cut_short(bytes: &[u8], declared: bool) -> bool {
    let printable = |b: &u8| matches!(b, b' '..=b'~' | b'\t' | b'\r' | b'\n' | 0xA0..);
    promised(bytes)
        .is_some_and(|(count, length)| count <= MAX_PROMISED && (bytes.len() as u64) < length)
        && foreign::kind(bytes).is_none()
        && !bytes.starts_with(b"PK\x03\x04")
        && (declared
            || bytes[..80]
                .iter()
                .skip_while(|b| printable(b))
                .all(|b| matches!(b, 0 | b' ')))
}

/// Reads every solid of a file that [`fits`] or [`is_cut_short`].
pub(crate) fn read(bytes: &[u8], mut mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let (count, length) = promised(bytes).unwrap_or((0, HEADER as u64));
    let Some(layout) = Layout::of(bytes) else {
        let body = bytes.get(HEADER..).unwrap_or_default();
        return Err(mesh.malformed(
            Place::Byte(bytes.len()),
            format!(
                "the file is cut short: its header promises {count} triangles ({length} bytes), \
                 but only {} bytes were received, enough for {}; send the whole file",
                bytes.len(),
                body.len() / RECORD
            ),
        ));
    };
    match layout {
        Layout::Solids { solids, trailer } => {
            let triangles = (bytes.len() - trailer - solids * HEADER) / RECORD;
            // The bytes are there, so this reserves no more than in proportion to the file.
            mesh.reserve(3 * triangles, triangles);
            let mut rest = bytes;
            for _ in 0..solids {
                let (header, body) = rest.split_at(HEADER);
                let count = promised(header).map_or(0, |(count, _)| count as usize);
                let (records, behind) = body.split_at(count * RECORD);
                if solids > 1 {
                    mesh.begin_part(name(header));
                }
                for record in records.chunks_exact(RECORD) {
                    triangle(record, &mut mesh)?;
                }
                rest = behind;
            }
            check_rest(rest, bytes.len(), &mut mesh)?;
        }
        Layout::Payload => {
            mesh.reserve(3 * count as usize, count as usize);
            let mut rest = &bytes[HEADER..];
            let mut passed_over = 0;
            while let Some((record, payload, behind)) = split_record(rest) {
                triangle(record, &mut mesh)?;
                passed_over += payload;
                rest = behind;
            }
            mesh.warn(
                WarningKind::File,
                format!(
                    "{passed_over} bytes of attributes between the triangles were passed over; compare the body \
                     with what you expect"
                ),
            );
        }
    }
    mesh.finish()
}

/// The name in the header of a solid: its text, up to a NUL byte and without the word `solid`.
fn name(header: &[u8]) -> &[u8] {
    let text = header[..80].split(|&b| b == 0).next().unwrap_or_default();
    let text = text.trim_ascii();
    text.strip_prefix(b"solid").map_or(text, <[u8]>::trim_ascii)
}

/// Adds the triangle of a record.
fn triangle(record: &[u8], mesh: &mut Builder<'_>) -> Result<(), ReadError> {
    let at = Place::Triangle(mesh.triangles());
    let (floats, _) = record.as_chunks::<4>();
    let mut corners = [0; 3];
    // The first three floats are the normal, which follows from the winding.
    for (corner, xyz) in corners.iter_mut().zip(floats[3..].chunks_exact(3)) {
        let xyz = [xyz[0], xyz[1], xyz[2]].map(|x| f64::from(f32::from_le_bytes(x)));
        *corner = mesh.single_vertex(xyz, at)?;
    }
    mesh.triangle(corners)
}

/// Warns of bytes behind the last solid, and refuses the beginning of one more.
fn check_rest(rest: &[u8], length: usize, mesh: &mut Builder<'_>) -> Result<(), ReadError> {
    if begins_solid(rest) {
        let promised = promised(rest).map_or(0, |(count, _)| count);
        let what = format!(
            "one more solid begins here and is cut short: its header promises {promised} triangles, but only {} \
             bytes follow, enough for {}; send the whole file",
            rest.len(),
            (rest.len() - HEADER) / RECORD
        );
        return Err(mesh.malformed(Place::Byte(length - rest.len()), what));
    }
    if !rest.is_empty() {
        let detail = format!(
            "{} bytes behind the last triangle were passed over; if something is missing, export the mesh again",
            rest.len()
        );
        mesh.warn(WarningKind::File, detail);
    }
    Ok(())
}
