//! Wavefront OBJ: the `v` and `f` statements of the text; everything else is skipped, so that a
//! `mtllib` is a word and never a file to be opened.

use super::builder::Builder;
use super::text::{Lines, fields, number, shown};
use super::{Place, ReadError};
use graspd_core::mesh::RawMesh;

/// Reads all faces of all groups and objects, in order.
pub(super) fn read(bytes: &[u8], mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let mut reader = Reader {
        mesh,
        corners: Vec::new(),
        highest: None,
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
    /// The highest vertex named, from 0, and where: a face may stand before its vertices.
    highest: Option<(u32, Place)>,
}

impl Reader<'_> {
    fn statement(&mut self, line: &[u8], at: Place) -> Result<(), ReadError> {
        let mut words = fields(line).take_while(|word| !word.starts_with(b"#"));
        match words.next() {
            Some(b"v") => self.vertex(words, at),
            Some(b"f") => self.face(words, at),
            _ => Ok(()),
        }
    }

    /// A colour or a weight may follow the position.
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
                    "a vertex of fewer than three coordinates; add the missing ones",
                )
            })?;
            *x = number(word).ok_or_else(|| {
                self.mesh.malformed(
                    at,
                    format!("`{}` is not a coordinate; correct the line", shown(word)),
                )
            })?;
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

    /// The vertex of `7`, `7/1`, `7//3` or `7/1/3`, from 0; negative numbers count back from the
    /// last vertex so far. Textures and normals are of no use here and not even looked at.
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
            wrong(if vertex < 0 {
                "counts back to before the first vertex"
            } else {
                "is out of range"
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
