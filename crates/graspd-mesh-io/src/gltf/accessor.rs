//! Numbers in the buffers of a glTF document; nothing is believed before it is checked against the bytes.
//!
//! An accessor describes elements of one to sixteen numbers of one type, at equal distances in a part of a buffer:
//!
//! ```text
//! buffer      |.................................................|
//! bufferView        |.....................................|          byteOffset, byteLength
//! accessor             |xyz...|xyz...|xyz...|xyz|                    byteOffset, byteStride, count
//! ```
//!
//! Only positions (three numbers) and vertex numbers (one) are read. The view must lie within its buffer, and the last
//! element must end within the view; the offsets come from the file and may be anything up to 2⁶⁴, so they are added
//! and multiplied with checks. After that, [`Column::element`] can slice without failing. A sparse accessor replaces
//! some of its elements: their ascending numbers and their values are two columns more, merged while reading. One
//! without a view of its own begins as zeros.
//!
//! **Cost:** O(count) each time an accessor is read. A small file may name one accessor many times, so the limits of the
//! [builder](crate::builder::Builder) are what bounds the work.

use std::borrow::Cow;

use super::document::{Accessor, Document, Shape, Sparse};
use super::{Source, item};
use crate::ReadError;

/// The fault of an accessor that has neither a view nor sparse values.
const NO_NUMBERS: &str = "it has no bufferView, and so no numbers; they may be compressed, as by Draco or meshopt: export \
    the mesh uncompressed";

/// The type of a number.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The value of as many bytes as the type has. A double holds every one exactly.
    fn value(self, bytes: &[u8]) -> f64 {
        let mut first = [0; 4];
        first[..bytes.len()].copy_from_slice(bytes);
        let [a, b, ..] = first;
        match self {
            Self::I8 => f64::from(a as i8),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::U32 => f64::from(u32::from_le_bytes(first)),
            Self::F32 => f64::from(f32::from_le_bytes(first)),
        }
    }

    /// The fraction that a whole number stands for in a normalized accessor, by the rules of the specification.
    fn fraction(self, value: f64) -> f64 {
        match self {
            Self::I8 => (value / 127.0).max(-1.0),
            Self::U8 => value / 255.0,
            Self::I16 => (value / 32767.0).max(-1.0),
            Self::U16 => value / 65535.0,
            Self::U32 | Self::F32 => value,
        }
    }
}

/// Elements of equal size, one every `stride` bytes, all within `bytes`.
struct Column<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: Component,
    width: usize,
    count: usize,
}

impl Column<'_> {
    fn element(&self, index: usize) -> impl Iterator<Item = f64> {
        let size = self.component.size() as usize;
        let begin = index * self.stride;
        let bytes = &self.bytes[begin..begin + size * self.width];
        bytes
            .chunks_exact(size)
            .map(|bytes| self.component.value(bytes))
    }

    /// An element as a position.
    fn position(&self, index: usize) -> [f64; 3] {
        let mut position = [0.0; 3];
        let element = self.element(index);
        let places = position.iter_mut().zip(element);
        places.for_each(|(x, value)| *x = value);
        position
    }
}

/// Reads accessors of one document.
pub(super) struct Accessors<'a> {
    document: &'a Document<'a>,
    buffers: Vec<Cow<'a, [u8]>>,
    source: Source,
}

impl<'a> Accessors<'a> {
    /// `buffers` are those of the document, in its order.
    pub(super) fn new(
        document: &'a Document<'a>,
        buffers: Vec<Cow<'a, [u8]>>,
        source: Source,
    ) -> Self {
        Self {
            document,
            buffers,
            source,
        }
    }

    /// Calls `each` with every position of an accessor, in order.
    pub(super) fn positions(
        &self,
        index: u32,
        mut each: impl FnMut([f64; 3]) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let accessor = self.accessor(index)?;
        let column = self.column(index, accessor, Shape::Vec3)?;
        if column.component == Component::U32 {
            return Err(self.wrong(
                index,
                "positions must not be 32-bit whole numbers; export floats",
            ));
        }
        let sparse = match &accessor.sparse {
            Some(sparse) => self.overrides(index, accessor, sparse)?,
            None => Vec::new(),
        };
        let mut sparse = sparse.into_iter().peekable();
        for n in 0..column.count {
            let mut position = column.position(n);
            while let Some((_, replaced)) = sparse.next_if(|(at, _)| *at <= n) {
                position = replaced;
            }
            if accessor.normalized {
                position = position.map(|x| column.component.fraction(x));
            }
            each(position)?;
        }
        Ok(())
    }

    /// How many elements an accessor has.
    pub(super) fn count(&self, index: u32) -> Result<u64, ReadError> {
        Ok(self.accessor(index)?.count)
    }

    /// The vertex numbers of an accessor.
    pub(super) fn indices(
        &self,
        index: u32,
    ) -> Result<impl ExactSizeIterator<Item = u32> + use<'_, 'a>, ReadError> {
        let accessor = self.accessor(index)?;
        let column = self.column(index, accessor, Shape::Scalar)?;
        let whole = matches!(
            column.component,
            Component::U8 | Component::U16 | Component::U32
        );
        if !whole || accessor.normalized || accessor.sparse.is_some() {
            let what =
                "vertex numbers must be plain 8, 16 or 32-bit whole numbers; export the mesh again";
            return Err(self.wrong(index, what));
        }
        Ok((0..column.count).map(move |n| column.element(n).next().unwrap_or_default() as u32))
    }

    /// The positions that replace others: the numbers of those, ascending, and the new values.
    fn overrides(
        &self,
        index: u32,
        accessor: &Accessor,
        sparse: &Sparse,
    ) -> Result<Vec<(usize, [f64; 3])>, ReadError> {
        let places = Accessor {
            buffer_view: Some(sparse.indices.buffer_view),
            byte_offset: sparse.indices.byte_offset,
            component_type: sparse.indices.component_type,
            normalized: false,
            count: sparse.count,
            shape: Shape::Scalar,
            sparse: None,
        };
        let values = Accessor {
            buffer_view: Some(sparse.values.buffer_view),
            byte_offset: sparse.values.byte_offset,
            component_type: accessor.component_type,
            normalized: false,
            count: sparse.count,
            shape: Shape::Vec3,
            sparse: None,
        };
        let places = self.column(index, &places, Shape::Scalar)?;
        let values = self.column(index, &values, Shape::Vec3)?;
        if matches!(
            places.component,
            Component::F32 | Component::I8 | Component::I16
        ) {
            return Err(self.wrong(
                index,
                "the numbers of sparse elements must be whole; export the mesh again",
            ));
        }
        let mut found = Vec::with_capacity(places.count);
        for n in 0..places.count {
            let place = places.element(n).next().unwrap_or_default() as usize;
            if place >= accessor.count as usize
                || found.last().is_some_and(|(last, _)| *last >= place)
            {
                let what = "the numbers of sparse elements must be in range and ascending; export the mesh again";
                return Err(self.wrong(index, what));
            }
            found.push((place, values.position(n)));
        }
        Ok(found)
    }

    fn accessor(&self, index: u32) -> Result<&'a Accessor, ReadError> {
        let found = self.document.accessors.0.get(index as usize);
        found.ok_or_else(|| {
            self.wrong(
                index,
                "it is referred to, but does not exist; export the mesh again",
            )
        })
    }

    /// The elements of an accessor, all of which lie within their view.
    fn column(
        &self,
        index: u32,
        accessor: &Accessor,
        shape: Shape,
    ) -> Result<Column<'_>, ReadError> {
        if accessor.shape != shape {
            return Err(self.wrong(
                index,
                "its elements are of another type than positions or vertex numbers have; export the mesh again",
            ));
        }
        let component = Component::of_code(accessor.component_type).ok_or_else(|| {
            let what = format!(
                "{} is not a component type; export the mesh again",
                accessor.component_type
            );
            self.wrong(index, &what)
        })?;
        let width: u64 = if shape == Shape::Vec3 { 3 } else { 1 };
        let Some(view) = accessor.buffer_view else {
            if accessor.sparse.is_none() {
                return Err(self.wrong(index, NO_NUMBERS));
            }
            return Ok(Column {
                bytes: &[],
                // Every element has its bytes at the same place, where there are none.
                stride: 0,
                component,
                width: 0,
                count: self.bounded(index, accessor.count)?,
            });
        };
        let (bytes, stride) = self.view(view)?;
        let size = component.size() * width;
        let stride = stride.unwrap_or(size);
        if stride < size {
            let what =
                format!("elements of {size} bytes every {stride} bytes; export the mesh again");
            return Err(self.wrong(index, &what));
        }
        let length = bytes.len() as u64;
        let needed = accessor
            .count
            .checked_sub(1)
            .and_then(|last| last.checked_mul(stride))
            .and_then(|last| last.checked_add(size))
            .and_then(|all| all.checked_add(accessor.byte_offset));
        let begin = usize::try_from(accessor.byte_offset).ok();
        match (needed, begin.and_then(|begin| bytes.get(begin..))) {
            (Some(needed), Some(bytes)) if needed <= length => Ok(Column {
                bytes,
                stride: stride as usize,
                component,
                width: width as usize,
                count: accessor.count as usize,
            }),
            _ => {
                let what = format!(
                    "{} elements every {stride} bytes from byte {} on do not fit into the {length} bytes of \
                     bufferView {view}; send the whole file or export it again",
                    accessor.count, accessor.byte_offset
                );
                Err(self.wrong(index, &what))
            }
        }
    }

    /// The count of an accessor without bytes of its own. It is bounded by the bytes of all buffers, since more zeros
    /// than the file could replace serve no purpose.
    fn bounded(&self, index: u32, count: u64) -> Result<usize, ReadError> {
        let bytes: usize = self.buffers.iter().map(|buffer| buffer.len()).sum();
        match usize::try_from(count) {
            Ok(count) if count <= bytes => Ok(count),
            _ => {
                let what = format!(
                    "it has {count} elements without a bufferView, more than the {bytes} bytes of the buffers could \
                     replace; export the mesh again"
                );
                Err(self.wrong(index, &what))
            }
        }
    }

    /// The bytes of a view, and the distance of its elements where it gives one.
    fn view(&self, index: u32) -> Result<(&[u8], Option<u64>), ReadError> {
        let wrong = |what: &str| self.source.malformed(item("bufferViews", index), what);
        let view = self.document.buffer_views.0.get(index as usize);
        let view = view
            .ok_or_else(|| wrong("it is referred to, but does not exist; export the mesh again"))?;
        let buffer = self.buffers.get(view.buffer as usize);
        let buffer =
            buffer.ok_or_else(|| wrong("its buffer does not exist; export the mesh again"))?;
        let end = view.byte_offset.checked_add(view.byte_length);
        let range = end.and_then(|end| {
            Some(usize::try_from(view.byte_offset).ok()?..usize::try_from(end).ok()?)
        });
        let bytes = range.and_then(|range| buffer.get(range)).ok_or_else(|| {
            wrong(&format!(
                "{} bytes from byte {} on are not within the {} bytes of buffer {}; send the whole file or \
                 export it again",
                view.byte_length,
                view.byte_offset,
                buffer.len(),
                view.buffer
            ))
        })?;
        Ok((bytes, view.byte_stride))
    }

    fn wrong(&self, index: u32, what: &str) -> ReadError {
        self.source.malformed(item("accessors", index), what)
    }
}
