//! ASCII STL, read by its words: any case, any line ends, any number of solids.
//!
//! ```text
//! solid NAME                          any words up to the end of the line
//!   facet normal NX NY NZ             ignored: the winding says it better
//!     outer loop
//!       vertex X Y Z                  three times
//!     endloop
//!   endfacet
//! endsolid NAME
//! ```
//!
//! A file that does not end with `endsolid` was cut short, and is refused even where its last facet is whole.

use crate::builder::Builder;
use crate::text::{Lines, Words, fields, has_decimal_comma, not_a_number, number, shown};
use graspd_core::mesh::RawMesh;

use crate::{Place, ReadError};

/// Whether a text begins like an ASCII STL file. The word `solid` alone may begin any text, so some facet or the end of
/// the solid must follow.
pub(crate) fn begins(bytes: &[u8]) -> bool {
    let mut words = Lines::new(bytes)
        .flat_map(|(_, line)| fields(line))
        .map(|word| word.to_ascii_lowercase());
    match words.next().as_deref() {
        Some(b"facet") => words.next().as_deref() == Some(b"normal"),
        Some(b"solid") => words.any(|word| word == b"facet" || word == b"endsolid"),
        _ => false,
    }
}

/// Reads every solid of the file, in order.
pub(crate) fn read(bytes: &[u8], mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let mut reader = Reader {
        words: Words::new(Lines::new(bytes)),
        mesh,
    };
    let mut complete = false;
    while let Some(word) = reader.words.next() {
        match word.to_ascii_lowercase().as_slice() {
            // A name may be any words, even `facet`.
            b"solid" => {
                let name = reader.words.take_line();
                reader.mesh.begin_part(name);
            }
            b"endsolid" => {
                reader.words.take_line();
                complete = true;
                continue;
            }
            b"facet" => reader.facet()?,
            // Some writers add a colour line of their own.
            b"color" => {
                reader.words.take_line();
            }
            _ => return Err(reader.unexpected(word, "facet or endsolid")),
        }
        complete = false;
    }
    if !complete {
        return Err(reader.cut_short());
    }
    reader.mesh.finish()
}

struct Reader<'a, 'p> {
    words: Words<'a>,
    mesh: Builder<'p>,
}

impl<'a> Reader<'a, '_> {
    /// Reads what follows `facet`, `endfacet` included.
    fn facet(&mut self) -> Result<(), ReadError> {
        self.expect(b"normal")?;
        // The normal follows from the winding; degenerate facets often carry `nan` here.
        for _ in 0..3 {
            self.word()?;
        }
        self.expect(b"outer")?;
        self.expect(b"loop")?;
        let mut corners = [0; 3];
        for corner in &mut corners {
            self.expect(b"vertex")?;
            let xyz = [self.coordinate()?, self.coordinate()?, self.coordinate()?];
            *corner = self.mesh.vertex(xyz, Place::Line(self.words.line()))?;
        }
        self.expect(b"endloop")?;
        self.expect(b"endfacet")?;
        self.mesh.triangle(corners)
    }

    fn word(&mut self) -> Result<&'a [u8], ReadError> {
        match self.words.next() {
            Some(word) => Ok(word),
            None => Err(self.cut_short()),
        }
    }

    fn expect(&mut self, keyword: &[u8]) -> Result<(), ReadError> {
        let word = self.word()?;
        if word.eq_ignore_ascii_case(keyword) {
            return Ok(());
        }
        Err(self.unexpected(word, &shown(keyword)))
    }

    fn coordinate(&mut self) -> Result<f64, ReadError> {
        let word = self.word()?;
        number(word).ok_or_else(|| {
            let at = Place::Line(self.words.line());
            match has_decimal_comma(word) {
                true => self.mesh.malformed(at, not_a_number(word, "a number")),
                false => self.unexpected(word, "a number"),
            }
        })
    }

    fn unexpected(&self, word: &[u8], wanted: &str) -> ReadError {
        self.mesh.malformed(
            Place::Line(self.words.line()),
            format!(
                "found `{}` where {wanted} was expected, after {} whole triangles; export the mesh again",
                shown(word),
                self.mesh.triangles()
            ),
        )
    }

    fn cut_short(&self) -> ReadError {
        self.mesh.malformed(
            Place::Line(self.words.line()),
            format!(
                "the file ends without endsolid, after {} whole triangles; send the whole file",
                self.mesh.triangles()
            ),
        )
    }
}
