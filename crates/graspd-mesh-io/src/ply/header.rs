//! The header of a PLY file: which elements follow, how many of each, with which properties.
//!
//! ```text
//! ply
//! format binary_little_endian 1.0
//! element vertex 8
//! property double x
//! ...
//! element face 12
//! property list uchar int vertex_indices
//! end_header
//! ```

use crate::text::{Lines, fields, shown};
use crate::{MeshFormat, Place, ReadError};

/// How the values after the header are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// The type with that name; two families of names are in use.
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// The bytes that a value takes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug)]
pub(super) struct Property<'a> {
    pub(super) name: &'a [u8],
    pub(super) kind: Kind,
}

#[derive(Debug)]
pub(super) struct Element<'a> {
    pub(super) name: &'a [u8],
    /// As the header has it; nothing says yet that so many follow.
    pub(super) count: u64,
    pub(super) properties: Vec<Property<'a>>,
    /// The line of the header that declares it.
    pub(super) line: usize,
}

#[derive(Debug)]
pub(super) struct Header<'a> {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element<'a>>,
    /// Lines of the header, `end_header` included.
    pub(super) lines: usize,
    /// Everything after the header.
    pub(super) body: &'a [u8],
}

pub(super) fn malformed(at: Place, what: impl Into<String>) -> ReadError {
    ReadError::Malformed {
        format: MeshFormat::Ply,
        at,
        what: what.into(),
    }
}

/// Reads up to and with `end_header`.
pub(super) fn parse(bytes: &[u8]) -> Result<Header<'_>, ReadError> {
    let mut lines = Lines::new(bytes);
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut last = 1;
    while let Some((line, text)) = lines.next() {
        last = line;
        let wrong = |what: &str| {
            malformed(
                Place::Line(line),
                format!("`{}` {what}; export the mesh again", shown(text)),
            )
        };
        let words: Vec<&[u8]> = fields(text).take(5).collect();
        match words.as_slice() {
            [] | [b"ply" | b"comment" | b"obj_info", ..] => {}
            [b"format", name, ..] => {
                encoding = Some(match *name {
                    b"ascii" => Encoding::Ascii,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(wrong("is not a known encoding")),
                });
            }
            [b"element", name, count, ..] => elements.push(Element {
                name,
                count: std::str::from_utf8(count)
                    .ok()
                    .and_then(|count| count.parse().ok())
                    .ok_or_else(|| wrong("does not have a valid count"))?,
                properties: Vec::new(),
                line,
            }),
            [b"property", rest @ ..] => {
                let property = property(rest).ok_or_else(|| wrong("is not a valid property"))?;
                elements
                    .last_mut()
                    .ok_or_else(|| wrong("comes before any element"))?
                    .properties
                    .push(property);
            }
            [b"end_header", ..] => {
                let encoding = encoding.ok_or_else(|| wrong("comes before any format line"))?;
                return Ok(Header {
                    encoding,
                    elements,
                    lines: line,
                    body: lines.rest(),
                });
            }
            _ => return Err(wrong("does not belong in the header")),
        }
    }
    Err(malformed(
        Place::Line(last),
        "the file ends inside its header; send the whole file",
    ))
}

fn property<'a>(words: &[&'a [u8]]) -> Option<Property<'a>> {
    Some(match *words {
        [b"list", count, item, name, ..] => Property {
            name,
            kind: Kind::List {
                count: Scalar::from_name(count)?,
                item: Scalar::from_name(item)?,
            },
        },
        [scalar, name, ..] => Property {
            name,
            kind: Kind::Scalar(Scalar::from_name(scalar)?),
        },
        _ => return None,
    })
}
