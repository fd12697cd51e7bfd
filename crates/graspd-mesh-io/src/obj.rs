//! Wavefront OBJ: the `v` and `f` statements of the text; everything else is skipped, so that a
//! `mtllib` is a word and never a file to be opened.
//!
//! Objects (`o`) name parts, and in a file without them groups (`g`) do.
//!
//! A line is a statement; a line that ends with a backslash goes on in the next one. A face may name vertices that
//! come after it, so indices are checked at the end, and the place of the highest one is remembered for the message.

use super::builder::Builder;
use super::text::{Lines, fields, has_decimal_comma, not_a_number, number, shown};
use super::{Place, ReadError};
use graspd_core::mesh::RawMesh;

/// The statements of the specification, those that it calls superseded included.
const STATEMENTS: [&[u8]; 44] = [
    b"v",
    b"vt",
    b"vn",
    b"vp",
    b"deg",
    b"bmat",
    b"step",
    b"cstype",
    b"p",
    b"l",
    b"f",
    b"fo",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"g",
    b"s",
    b"mg",
    b"o",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"usemtl",
    b"mtllib",
    b"usemap",
    b"maplib",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"call",
    b"csh",
    b"bsp",
    b"bzp",
    b"cdc",
    b"cdp",
];

/// Whether a text is an OBJ file. Either its first statement is one of OBJ's and somewhere there is a vertex or a face
/// with a number, or it begins with a line of words, which some programs forget to mark as a comment, and has a whole
/// vertex and a whole face. A sender who `declared` OBJ is believed where there is either.
///
/// The tests for numbers are for prose: an English sentence may begin with "o", but hardly has a line like `v 1`.
pub(super) fn begins(bytes: &[u8], declared: bool) -> bool {
    let mut has_statement_first = None;
    let [mut vertex, mut face] = [false; 2];
    for (_, line) in Lines::new(bytes) {
        let mut words = fields(line).take_while(|word| !word.starts_with(b"#"));
        let Some(keyword) = words.next() else {
            continue;
        };
        let begins =
            *has_statement_first.get_or_insert_with(|| declared || STATEMENTS.contains(&keyword));
        let needed = if begins { 1 } else { 3 };
        let is_value = |word: &&[u8]| number(word).is_some() || has_decimal_comma(word);
        let is_corner = |word: &&[u8]| word.split(|&b| b == b'/').next().and_then(number).is_some();
        match keyword {
            b"v" => vertex |= words.take(needed).filter(is_value).count() == needed,
            b"f" => face |= words.take(needed).filter(is_corner).count() == needed,
            _ => {}
        }
        if (vertex && face) || (begins && (vertex || face)) {
            return true;
        }
    }
    false
}

/// Reads all faces of all groups and objects, in order.
pub(super) fn read(bytes: &[u8], mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let mut reader = Reader {
        mesh,
        corners: Vec::new(),
        highest: None,
        has_objects: false,
    };
    let mut lines = Lines::new(bytes);
    let mut joined = Vec::new();
    while let Some((number, line)) = lines.next() {
        let continued = |line: &[u8]| line.ends_with(b"\\") && !line.starts_with(b"#");
        if !continued(line) {
            reader.statement(line, Place::Line(number))?;
            continue;
        }
        joined.clear();
        joined.extend_from_slice(&line[..line.len() - 1]);
        for (_, next) in lines.by_ref() {
            joined.push(b' ');
            joined.extend_from_slice(next.strip_suffix(b"\\").unwrap_or(next));
            if !continued(next) {
                break;
            }
        }
        reader.statement(&joined, Place::Line(number))?;
    }
    reader.finish()
}

struct Reader<'a> {
    mesh: Builder<'a>,
    /// Corners of the face at hand.
    corners: Vec<u32>,
    /// The highest vertex that a face names, counted from 0, and the line of that face.
    highest: Option<(u32, Place)>,
    /// Whether an object has begun, so that groups name no parts.
    has_objects: bool,
}

impl Reader<'_> {
    fn statement(&mut self, line: &[u8], at: Place) -> Result<(), ReadError> {
        let mut words = fields(line).take_while(|word| !word.starts_with(b"#"));
        match words.next() {
            Some(b"v") => self.vertex(words, at),
            Some(b"f") => self.face(words, at),
            Some(b"o") => {
                self.has_objects = true;
                self.mesh
                    .continue_part(&words.collect::<Vec<_>>().join(&b' '));
                Ok(())
            }
            Some(b"g") if !self.has_objects => {
                self.mesh
                    .continue_part(&words.collect::<Vec<_>>().join(&b' '));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Reads a position; a weight or a colour may follow it.
    fn vertex<'w>(
        &mut self,
        mut words: impl Iterator<Item = &'w [u8]>,
        at: Place,
    ) -> Result<(), ReadError> {
        let mut position = [0.0; 3];
        for x in &mut position {
            let word = words.next().ok_or_else(|| {
                self.mesh.malformed(
                    at,
                    "a vertex has fewer than three coordinates; add the missing ones",
                )
            })?;
            *x = number(word)
                .ok_or_else(|| self.mesh.malformed(at, not_a_number(word, "a coordinate")))?;
        }
        self.mesh.vertex(position, at)?;
        Ok(())
    }

    fn face<'w>(
        &mut self,
        words: impl Iterator<Item = &'w [u8]>,
        at: Place,
    ) -> Result<(), ReadError> {
        self.corners.clear();
        for word in words {
            let index = self.index(word, at)?;
            if self.highest.is_none_or(|(highest, _)| highest < index) {
                self.highest = Some((index, at));
            }
            self.corners.push(index);
        }
        self.mesh.polygon(&self.corners, at)
    }

    /// The vertex that `7`, `7/1`, `7//3` or `7/1/3` names, counted from 0; negative numbers count back from the
    /// last vertex so far. Texture coordinates and normals are not even looked at.
    fn index(&self, word: &[u8], at: Place) -> Result<u32, ReadError> {
        let wrong = |why: &str| {
            self.mesh.malformed(
                at,
                format!("corner `{}` {why}; export the mesh again", shown(word)),
            )
        };
        let vertex: i64 = word
            .split(|&b| b == b'/')
            .next()
            .and_then(|vertex| std::str::from_utf8(vertex).ok())
            .and_then(|vertex| vertex.parse().ok())
            .ok_or_else(|| wrong("is not a vertex number"))?;
        let index = match vertex {
            0 => return Err(wrong("is vertex 0, and OBJ counts from 1")),
            1.. => vertex - 1,
            _ => self.mesh.vertices() as i64 + vertex,
        };
        u32::try_from(index).map_err(|_| {
            wrong(match vertex < 0 {
                true => "counts back to before the first vertex",
                false => "is out of range",
            })
        })
    }

    fn finish(self) -> Result<RawMesh, ReadError> {
        let vertices = self.mesh.vertices();
        match self.highest {
            Some((index, at)) if index as usize >= vertices => Err(self.mesh.malformed(
                at,
                format!(
                    "the face names vertex {}, but the file has {vertices} vertices; send the whole file or export it again",
                    u64::from(index) + 1
                ),
            )),
            _ => self.mesh.finish(),
        }
    }
}
