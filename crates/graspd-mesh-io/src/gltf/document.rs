//! The members of a glTF document that matter for its triangles; all others are skipped.
//!
//! The names are those of the specification (glTF 2.0, section 5). Text is borrowed from the file.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

/// The most entries of one list. Without it, a file with a few bytes for each entry could take a hundred times its size
/// in memory.
const MAX_ENTRIES: usize = 1 << 18;

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document<'a> {
    pub(super) asset: Asset<'a>,
    #[serde(default)]
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) scenes: List<Scene>,
    #[serde(default, borrow)]
    pub(super) nodes: List<Node<'a>>,
    #[serde(default, borrow)]
    pub(super) meshes: List<Mesh<'a>>,
    #[serde(default)]
    pub(super) accessors: List<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: List<BufferView>,
    #[serde(default, borrow)]
    pub(super) buffers: List<Buffer<'a>>,
    #[serde(default, borrow)]
    pub(super) extensions_required: List<Cow<'a, str>>,
}

#[derive(serde::Deserialize)]
pub(super) struct Asset<'a> {
    #[serde(borrow)]
    pub(super) version: Cow<'a, str>,
}

#[derive(serde::Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<u32>,
}

#[derive(serde::Deserialize)]
pub(super) struct Node<'a> {
    #[serde(default, borrow)]
    pub(super) name: Option<Cow<'a, str>>,
    #[serde(default)]
    pub(super) children: Vec<u32>,
    #[serde(default)]
    pub(super) mesh: Option<u32>,
    /// In column-major order.
    #[serde(default)]
    pub(super) matrix: Option<Box<[f64; 16]>>,
    #[serde(default)]
    pub(super) translation: Option<Box<[f64; 3]>>,
    /// A quaternion x, y, z, w.
    #[serde(default)]
    pub(super) rotation: Option<Box<[f64; 4]>>,
    #[serde(default)]
    pub(super) scale: Option<Box<[f64; 3]>>,
}

#[derive(serde::Deserialize)]
pub(super) struct Mesh<'a> {
    #[serde(default, borrow)]
    pub(super) name: Option<Cow<'a, str>>,
    pub(super) primitives: List<Primitive>,
}

#[derive(serde::Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: Attributes,
    #[serde(default)]
    pub(super) indices: Option<u32>,
    #[serde(default = "triangles")]
    pub(super) mode: u32,
}

/// The mode of a primitive that does not name one.
fn triangles() -> u32 {
    4
}

#[derive(serde::Deserialize)]
pub(super) struct Attributes {
    #[serde(default, rename = "POSITION")]
    pub(super) position: Option<u32>,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    #[serde(default)]
    pub(super) buffer_view: Option<u32>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: u64,
    #[serde(rename = "type")]
    pub(super) shape: Shape,
    #[serde(default)]
    pub(super) sparse: Option<Box<Sparse>>,
}

/// How many components an element has.
#[derive(serde::Deserialize, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    #[serde(rename = "SCALAR")]
    Scalar,
    #[serde(rename = "VEC3")]
    Vec3,
    #[serde(other)]
    Other,
}

#[derive(serde::Deserialize)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: u32,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: u32,
    #[serde(default)]
    pub(super) byte_offset: u64,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: u32,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    #[serde(default)]
    pub(super) byte_stride: Option<u64>,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer<'a> {
    #[serde(default, borrow)]
    pub(super) uri: Option<Cow<'a, str>>,
    pub(super) byte_length: u64,
}

/// A list of at most [`MAX_ENTRIES`].
pub(super) struct List<T>(pub(super) Vec<T>);

impl<T> Default for List<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for List<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
            type Value = Vec<T>;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(formatter, "a list of at most {MAX_ENTRIES} entries")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Vec<T>, A::Error> {
                let mut list = Vec::new();
                while let Some(entry) = entries.next_element()? {
                    if list.len() == MAX_ENTRIES {
                        return Err(Error::invalid_length(MAX_ENTRIES + 1, &self));
                    }
                    list.push(entry);
                }
                Ok(list)
            }
        }
        deserializer.deserialize_seq(Entries(PhantomData)).map(List)
    }
}
