//! OFF (Geomview's object file format): vertices and polygons as words of text.
//!
//! ```text
//! OFF                     optional; the letters before it say what follows each position
//! VERTICES FACES EDGES
//! X Y Z ...               for each vertex
//! CORNERS I J K ...       for each face, perhaps with a colour
//! ```
//!
//! By the specification the lines matter only behind a face, whose colour ends with its line. Other files have colours
//! behind positions without saying so, several vertices on a line, or a vertex on several. One rule reads them all: what
//! is left of a line behind a vertex or a face is passed over as long as there are enough lines for the rest, and
//! belongs to the next one otherwise. Where there are exactly as many lines as vertices and faces, each has its line, and
//! one that is too short is an error there.
//!
//! ModelNet's files have the first count glued to the header word. The header word is optional; without it only the
//! sender can say that two numbers begin an OFF file. Counts are never used to reserve memory: they only say how much
//! to expect.

use super::builder::Builder;
use super::text::{Lines, fields, not_a_number, number, shown};
use super::{Place, ReadError};
use graspd_core::mesh::{RawMesh, WarningKind};

/// Whether a text begins with a header word of OFF or, where that `may_lack`, with the counts that follow it.
pub(super) fn begins(bytes: &[u8], may_lack: bool) -> bool {
    let mut lines = Lines::new(bytes).map(|(_, line)| statement(line));
    let Some(line) = lines.find(|line| !line.is_empty()) else {
        return false;
    };
    let mut words = fields(line);
    let has_header = words.next().is_some_and(|word| header(word).is_some());
    let counts = || fields(line).count() >= 2 && fields(line).all(|word| number(word).is_some());
    has_header || (may_lack && counts())
}

/// A line without its comment.
fn statement(line: &[u8]) -> &[u8] {
    let line = line.split(|&b| b == b'#').next().unwrap_or_default();
    line.trim_ascii()
}

/// What the header word announces.
#[derive(Clone, Copy)]
struct Header {
    /// Whether positions have three coordinates.
    is_plain: bool,
    /// Words behind a position: a normal, a colour, texture coordinates.
    extras: usize,
    /// Bytes of the header word; a count may be glued to it.
    length: usize,
}

/// The header in a word: the letters before `OFF` say what follows each position, and how many dimensions it has.
fn header(word: &[u8]) -> Option<Header> {
    let upper = word.to_ascii_uppercase();
    let prefix = upper.windows(3).position(|at| at == b"OFF")?;
    let (letters, rest) = (&word[..prefix], &word[prefix + 3..]);
    let known = prefix <= 5
        && letters
            .to_ascii_uppercase()
            .iter()
            .all(|l| b"STCN4".contains(l));
    if !known || !rest.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let extra = |letter: &u8| match letter {
        b'N' => 3,
        b'C' => 4,
        b'S' => 2,
        _ => 0,
    };
    Some(Header {
        is_plain: !letters.iter().any(|letter| matches!(letter, b'4' | b'n')),
        extras: upper[..prefix].iter().map(extra).sum(),
        length: prefix + 3,
    })
}

/// Reads a file whose header word may be missing.
pub(super) fn read(bytes: &[u8], mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let lines = Lines::new(bytes).map(|(_, line)| statement(line));
    let mut reader = Reader {
        lines_left: lines.filter(|line| !line.is_empty()).count() as u64,
        lines: Lines::new(bytes),
        line: b"",
        number: 1,
        by_line: false,
        mesh,
    };
    let extras = reader.header()?;
    let vertices: u64 = reader.value("the number of vertices")?;
    let faces: u64 = reader.second_count()?;
    let items = vertices.saturating_add(faces);
    reader.skip_edges(items);
    reader.by_line = reader.lines_left == items && reader.line.is_empty();
    for n in 0..vertices {
        reader.vertex(n, vertices)?;
        reader.end_of_item((vertices - n - 1).saturating_add(faces), extras);
    }
    let mut corners = Vec::new();
    for n in 0..faces {
        reader.face(n, [vertices, faces], &mut corners)?;
        reader.end_of_item(faces - n - 1, 0);
    }
    if reader.lines_left > 0 {
        let detail = format!(
            "{} lines behind the last face were passed over; if something is missing, export the mesh again",
            reader.lines_left
        );
        reader.mesh.warn(WarningKind::File, detail);
    }
    reader.mesh.finish()
}

struct Reader<'a, 'p> {
    lines: Lines<'a>,
    /// What is left of the current line.
    line: &'a [u8],
    /// The number of the current line, from 1.
    number: usize,
    /// Lines behind the current one that are not empty.
    lines_left: u64,
    /// Whether each vertex and each face has a line of its own.
    by_line: bool,
    mesh: Builder<'p>,
}

impl<'a> Reader<'a, '_> {
    /// Reads the header word, if there is one; returns how many words follow each position.
    fn header(&mut self) -> Result<usize, ReadError> {
        self.fill("its header")?;
        let word = fields(self.line).next().unwrap_or_default();
        let Some(header) = header(word) else {
            return Ok(0);
        };
        if !header.is_plain {
            let what = format!(
                "`{}` announces vertices of other than three dimensions; export a plain OFF file",
                shown(word)
            );
            return Err(self.malformed(what));
        }
        // Counts may follow at once.
        self.line = &self.line[header.length..];
        let next = fields(self.line).next();
        if next.is_some_and(|word| word.eq_ignore_ascii_case(b"BINARY")) {
            let what = "binary OFF cannot be read; export the mesh as text, or as PLY";
            return Err(self.malformed(what.to_owned()));
        }
        Ok(header.extras)
    }

    /// Reads the number of faces, which stands behind that of vertices unless each number has a line of its own.
    fn second_count(&mut self) -> Result<u64, ReadError> {
        const WHAT: &str = "the number of faces";
        if self.line.is_empty() && self.words_ahead() > 1 {
            return Err(self.missing(WHAT));
        }
        self.value(WHAT)
    }

    /// How many words the next line has that is not empty.
    fn words_ahead(&self) -> usize {
        let mut next = self.lines.clone().map(|(_, line)| statement(line));
        let next = next.find(|line| !line.is_empty());
        next.map_or(0, |line| fields(line).count())
    }

    /// Passes over the number of edges, which means nothing and may be missing; `items` follow it.
    fn skip_edges(&mut self, items: u64) {
        if self.line.is_empty() && (self.words_ahead() != 1 || self.fill("").is_err()) {
            return;
        }
        self.next_word();
        self.end_of_item(items, 0);
    }

    fn vertex(&mut self, n: u64, count: u64) -> Result<(), ReadError> {
        self.fill(&format!("vertex {n} of {count}"))?;
        let mut position = [0.0; 3];
        for x in &mut position {
            *x = self.value("a coordinate")?;
        }
        let at = self.place();
        self.mesh.vertex(position, at).map(|_| ())
    }

    /// Reads a face; `corners` is used again for each.
    fn face(
        &mut self,
        n: u64,
        [vertices, faces]: [u64; 2],
        corners: &mut Vec<u32>,
    ) -> Result<(), ReadError> {
        self.fill(&format!("face {n} of {faces}"))?;
        let at = self.place();
        let count: u32 = self.value("a number of corners")?;
        corners.clear();
        for _ in 0..count {
            let index: u32 = self.value("a vertex number")?;
            if u64::from(index) >= vertices {
                let what = format!(
                    "the face names vertex {index} (counted from 0), but the file has {vertices} vertices; \
                     export the mesh again"
                );
                return Err(self.malformed(what));
            }
            corners.push(index);
        }
        // Points and lines are no surface.
        match count {
            1 | 2 => Ok(()),
            _ => self.mesh.polygon(corners, at),
        }
    }

    /// Ends a vertex or a face behind which there are `items` more. Drops what is left of the line if there are enough
    /// lines for those, and else only so many `extras`.
    fn end_of_item(&mut self, items: u64, extras: usize) {
        if items <= self.lines_left {
            self.line = b"";
            return;
        }
        for _ in 0..extras {
            self.next_word();
        }
    }

    /// Makes sure that there is a word in the current line, and goes on to the next line if there is none.
    fn fill(&mut self, what: &str) -> Result<(), ReadError> {
        while self.line.is_empty() {
            let Some((number, line)) = self.lines.next() else {
                let what = format!("the file ends before {what}; send the whole file");
                return Err(self.malformed(what));
            };
            self.number = number;
            self.line = statement(line);
            self.lines_left -= u64::from(!self.line.is_empty());
        }
        Ok(())
    }

    /// Takes the next word of the current line.
    fn next_word(&mut self) -> Option<&'a [u8]> {
        self.line = self.line.trim_ascii_start();
        let end = self.line.iter().position(u8::is_ascii_whitespace);
        let (word, rest) = self.line.split_at(end.unwrap_or(self.line.len()));
        self.line = rest.trim_ascii_start();
        (!word.is_empty()).then_some(word)
    }

    fn value<T: std::str::FromStr>(&mut self, expected: &str) -> Result<T, ReadError> {
        if self.by_line && self.line.is_empty() {
            return Err(self.missing(expected));
        }
        self.fill(expected)?;
        let word = self.next_word().unwrap_or_default();
        let text = std::str::from_utf8(word).ok();
        let value = text.and_then(|text| text.parse().ok());
        value.ok_or_else(|| self.malformed(not_a_number(word, expected)))
    }

    fn missing(&self, expected: &str) -> ReadError {
        self.malformed(format!(
            "{expected} is missing; add it or export the mesh again"
        ))
    }

    fn place(&self) -> Place {
        Place::Line(self.number)
    }

    fn malformed(&self, what: String) -> ReadError {
        self.mesh.malformed(self.place(), what)
    }
}
