//! The values after a PLY header, one by one, in whichever encoding.
//!
//! Counts are compared with the bytes that are left before anything is read for them: no file can make a reader loop
//! for longer than its own length.

use crate::text::{Lines, Words, not_a_number, number, shown};
use crate::{Place, ReadError};

use super::header::{Element, Encoding, Header, Kind, Scalar, malformed};

/// A cursor over the body of the file.
pub(super) enum Values<'a> {
    Ascii(Words<'a>),
    Binary {
        rest: &'a [u8],
        /// Length of the whole file, from which the offset follows.
        length: usize,
        big_endian: bool,
    },
}

impl<'a> Values<'a> {
    pub(super) fn new(header: &Header<'a>, length: usize) -> Self {
        let binary = |big_endian| Self::Binary {
            rest: header.body,
            length,
            big_endian,
        };
        match header.encoding {
            Encoding::Ascii => Self::Ascii(Words::new(Lines::starting_at(
                header.body,
                header.lines + 1,
            ))),
            Encoding::LittleEndian => binary(false),
            Encoding::BigEndian => binary(true),
        }
    }

    pub(super) fn is_binary(&self) -> bool {
        matches!(self, Self::Binary { .. })
    }

    /// Where the next value is, for messages.
    pub(super) fn place(&self) -> Place {
        match self {
            Self::Ascii(words) => Place::Line(words.line()),
            Self::Binary { rest, length, .. } => Place::Byte(length - rest.len()),
        }
    }

    /// The most values of that type that the rest of the file can hold.
    fn room_for(&self, scalar: Scalar) -> u64 {
        match self {
            // A value takes a character and a separator, which the last one may lack.
            Self::Ascii(words) => (words.remaining() as u64).div_ceil(2),
            Self::Binary { rest, .. } => (rest.len() / scalar.size()) as u64,
        }
    }

    /// Refuses an element of which the header declares more than the rest of the file can hold.
    pub(super) fn check_room(&self, element: &Element) -> Result<(), ReadError> {
        let least: u64 = element
            .properties
            .iter()
            .map(|property| match (self, property.kind) {
                (Self::Ascii(_), _) => 2,
                (_, Kind::Scalar(scalar) | Kind::List { count: scalar, .. }) => {
                    scalar.size() as u64
                }
            })
            .sum();
        let remaining = match self {
            Self::Ascii(words) => words.remaining() as u64 + 1,
            Self::Binary { rest, .. } => rest.len() as u64,
        };
        if element
            .count
            .checked_mul(least)
            .is_some_and(|needed| needed <= remaining)
        {
            return Ok(());
        }
        Err(malformed(
            Place::Line(element.line),
            format!(
                "the header promises {} of element `{}`, more than the {remaining} bytes that follow can hold; send the whole file",
                element.count,
                shown(element.name)
            ),
        ))
    }

    /// The next value. A double holds the values of every type exactly.
    pub(super) fn scalar(&mut self, scalar: Scalar) -> Result<f64, ReadError> {
        let at = self.place();
        let cut_short = || malformed(at, "the file ends early; send the whole file");
        match self {
            Self::Ascii(words) => {
                let word = words.next().ok_or_else(cut_short)?;
                number(word).ok_or_else(|| {
                    malformed(Place::Line(words.line()), not_a_number(word, "a number"))
                })
            }
            Self::Binary {
                rest, big_endian, ..
            } => {
                let (value, tail) = rest.split_at_checked(scalar.size()).ok_or_else(cut_short)?;
                *rest = tail;
                let mut bytes = [0; 8];
                bytes[..value.len()].copy_from_slice(value);
                if *big_endian {
                    bytes[..value.len()].reverse();
                }
                Ok(decode(scalar, bytes))
            }
        }
    }

    /// The length of a list of `item`s, for which the rest of the file has room.
    pub(super) fn length(&mut self, count: Scalar, item: Scalar) -> Result<u64, ReadError> {
        let at = self.place();
        let length = self.scalar(count)?;
        let wrong = |why: &str| {
            malformed(
                at,
                format!("a list of length {length} {why}; export the mesh again"),
            )
        };
        if !(length >= 0.0 && length.fract() == 0.0) {
            return Err(wrong("is not possible"));
        }
        if length > self.room_for(item) as f64 {
            return Err(wrong("does not fit into the rest of the file"));
        }
        Ok(length as u64)
    }

    /// Skips a property.
    pub(super) fn skip(&mut self, kind: Kind) -> Result<(), ReadError> {
        match kind {
            Kind::Scalar(scalar) => {
                self.scalar(scalar)?;
            }
            Kind::List { count, item } => {
                for _ in 0..self.length(count, item)? {
                    self.scalar(item)?;
                }
            }
        }
        Ok(())
    }
}

/// A value from its little-endian bytes, the unused ones zero.
fn decode(scalar: Scalar, bytes: [u8; 8]) -> f64 {
    let [a, b, c, d, ..] = bytes;
    match scalar {
        Scalar::I8 => f64::from(i8::from_le_bytes([a])),
        Scalar::U8 => f64::from(a),
        Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
        Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
        Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        Scalar::F64 => f64::from_le_bytes(bytes),
    }
}
