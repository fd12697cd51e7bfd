//! OFF (Geomview's object file format): vertices and polygons as lines of text.
//!
//! A header word, the counts of vertices, faces and edges, then a line for each vertex and each face. Normals,
//! colours and texture coordinates that may follow a position, and colours that may follow a face, are skipped. The
//! header word is optional by the specification; without it only the sender can say that two numbers begin an OFF
//! file. Counts are never used to reserve memory: they only say how many lines to expect.

use super::builder::Builder;
use super::text::{Lines, fields, number, shown};
use super::{Place, ReadError};
use graspd_core::mesh::RawMesh;

/// Whether a text begins with a header word of OFF or, where that `may_lack`, with the counts that follow it.
pub(super) fn begins(bytes: &[u8], may_lack: bool) -> bool {
    let first = Statements(Lines::new(bytes)).next();
    first.is_some_and(|(_, words)| {
        let counts = || words.len() >= 2 && words.iter().all(|word| number(word).is_some());
        is_header(words[0]) || (may_lack && counts())
    })
}

/// Whether a word is the header of a file that [`read`] reads, or refuses with a reason of its own: the letters
/// before `OFF` say what follows each position, and how many dimensions it has.
fn is_header(word: &[u8]) -> bool {
    let upper = word.to_ascii_uppercase();
    let Some(prefix) = upper.strip_suffix(b"OFF") else {
        return false;
    };
    prefix.iter().all(|letter| b"STCN4".contains(letter)) && prefix.len() <= 5
}

/// Reads a file whose header word may be missing.
pub(super) fn read(bytes: &[u8], mut mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let mut lines = Statements(Lines::new(bytes));
    let (mut at, mut words) = lines.expect(&mesh, "its header")?;
    if words.first().is_some_and(|word| is_header(word)) {
        let header = words.remove(0);
        if header.iter().any(|letter| matches!(letter, b'4' | b'n')) {
            let what = format!(
                "`{}` announces vertices of other than three dimensions; export a plain OFF file",
                shown(header)
            );
            return Err(mesh.malformed(at, what));
        }
        if words
            .first()
            .is_some_and(|word| word.eq_ignore_ascii_case(b"BINARY"))
        {
            let what = "binary OFF cannot be read; export the mesh as text, or as PLY";
            return Err(mesh.malformed(at, what));
        }
        if words.is_empty() {
            (at, words) = lines.expect(&mesh, "its counts")?;
        }
    }
    let [vertices, faces] = counts(&mesh, at, &words)?;
    for n in 0..vertices {
        let (at, words) = lines.expect(&mesh, &format!("vertex {n} of {vertices}"))?;
        let mut position = [0.0; 3];
        for (axis, x) in position.iter_mut().enumerate() {
            *x = value(&mesh, at, words.get(axis), "a coordinate")?;
        }
        mesh.vertex(position, at)?;
    }
    let mut corners = Vec::new();
    for n in 0..faces {
        let (at, words) = lines.expect(&mesh, &format!("face {n} of {faces}"))?;
        let count: u32 = value(&mesh, at, words.first(), "a number of corners")?;
        corners.clear();
        for i in 1..=count as usize {
            let index: u32 = value(&mesh, at, words.get(i), "a vertex number")?;
            if u64::from(index) >= vertices {
                let what = format!(
                    "the face names vertex {index} (counted from 0), but the file has {vertices} vertices; \
                     export the mesh again"
                );
                return Err(mesh.malformed(at, what));
            }
            corners.push(index);
        }
        // Points and lines are no surface.
        if count != 1 && count != 2 {
            mesh.polygon(&corners, at)?;
        }
    }
    mesh.finish()
}

fn counts(mesh: &Builder<'_>, at: Place, words: &[&[u8]]) -> Result<[u64; 2], ReadError> {
    let count = |i: usize, what| value(mesh, at, words.get(i), what);
    Ok([
        count(0, "the number of vertices")?,
        count(1, "the number of faces")?,
    ])
}

fn value<T: std::str::FromStr>(
    mesh: &Builder<'_>,
    at: Place,
    word: Option<&&[u8]>,
    wanted: &str,
) -> Result<T, ReadError> {
    let Some(word) = word else {
        return Err(mesh.malformed(
            at,
            format!("{wanted} is missing; add it or export the mesh again"),
        ));
    };
    let text = std::str::from_utf8(word).ok();
    text.and_then(|text| text.parse().ok()).ok_or_else(|| {
        let what = format!(
            "found `{}` where {wanted} was expected; correct the line",
            shown(word)
        );
        mesh.malformed(at, what)
    })
}

/// The lines that are not empty, without their comments.
struct Statements<'a>(Lines<'a>);

impl<'a> Iterator for Statements<'a> {
    type Item = (Place, Vec<&'a [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        self.0.by_ref().find_map(|(line, text)| {
            let words = fields(text).take_while(|word| !word.starts_with(b"#"));
            let words: Vec<&[u8]> = words.collect();
            (!words.is_empty()).then_some((Place::Line(line), words))
        })
    }
}

impl<'a> Statements<'a> {
    fn expect(
        &mut self,
        mesh: &Builder<'_>,
        what: &str,
    ) -> Result<(Place, Vec<&'a [u8]>), ReadError> {
        self.next().ok_or_else(|| {
            let what = format!("the file ends before {what}; send the whole file");
            mesh.malformed(Place::Line(self.0.number().max(1)), what)
        })
    }
}
