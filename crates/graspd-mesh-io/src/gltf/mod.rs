//! glTF 2.0, as a binary GLB or as one JSON document with its buffers inside.
//!
//! What comes out are the triangles of the scene in its own frame: the transforms of nodes are applied, all meshes are
//! merged in the order of the nodes, skins and morphs are left at rest, and everything that is not a surface is
//! skipped. No second file is opened. The reader is our own because the `gltf` crate panics on accessors that reach
//! beyond their buffers.
//!
//! A GLB file is a header, a chunk of JSON and a chunk of bytes. The JSON refers to itself by position in its lists:
//!
//! ```text
//! scene → nodes → mesh → primitives → accessors → bufferViews → buffers
//! ```
//!
//! `document.rs` has the lists, `scene.rs` goes from the scene to the primitives, and `accessor.rs` from there to the
//! bytes. Every reference and every length is checked on the way.

mod accessor;
mod document;
mod scene;
#[cfg(test)]
mod tests;

use graspd_core::mesh::RawMesh;
use std::borrow::Cow;

use base64::Engine;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD};

use self::accessor::Accessors;
use self::document::Document;
use self::scene::Scene;
use super::builder::Builder;
use super::text::shown;
use super::{MeshFormat, Place, ReadError};

const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// Extensions that change no triangle, so a file that requires them is read all the same.
const HARMLESS: [&str; 5] = [
    "KHR_mesh_quantization",
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
];

/// Which of the two kinds of file is read, for messages.
#[derive(Debug, Clone, Copy)]
struct Source(MeshFormat);

impl Source {
    fn malformed(self, at: Place, what: impl Into<String>) -> ReadError {
        ReadError::Malformed {
            format: self.0,
            at,
            what: what.into(),
        }
    }
}

fn item(list: &'static str, index: u32) -> Place {
    Place::Item(list, index as usize)
}

/// Whether a file begins as GLB does.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF")
}

/// Whether a text looks like a glTF document: JSON that has the member `asset`. One pass at most.
pub(super) fn is_document(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let key = b"\"asset\"";
    text.trim_ascii_start().starts_with(b"{") && text.windows(key.len()).any(|at| at == key)
}

/// Reads a file that [`is_binary`].
pub(super) fn read_binary(bytes: &[u8], mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let source = Source(MeshFormat::Glb);
    let word = |at: usize| {
        let word = bytes.get(at..at + 4).and_then(|word| word.first_chunk());
        word.map(|word| u32::from_le_bytes(*word)).ok_or_else(|| {
            let what = "the file is cut short inside its header; send the whole file";
            source.malformed(Place::Byte(bytes.len()), what)
        })
    };
    let (version, length) = (word(4)?, word(8)? as usize);
    if version != 2 {
        let what = format!(
            "this is glTF version {version}, but only version 2 can be read; export the mesh again"
        );
        return Err(source.malformed(Place::Byte(4), what));
    }
    let Some(bytes) = bytes.get(..length) else {
        let what = format!(
            "the file is cut short: its header promises {length} bytes, but only {} were received; send the whole file",
            bytes.len()
        );
        return Err(source.malformed(Place::Byte(bytes.len()), what));
    };
    let chunk = |begin: usize| -> Result<(u32, &[u8], usize), ReadError> {
        let (size, kind) = (word(begin)? as usize, word(begin + 4)?);
        let data = begin + CHUNK_HEADER;
        let body = data.checked_add(size).and_then(|end| bytes.get(data..end));
        let body = body.ok_or_else(|| {
            let what = format!(
                "a chunk of {size} bytes reaches beyond the end of the file; send the whole file"
            );
            source.malformed(Place::Byte(begin), what)
        })?;
        Ok((kind, body, (data + size).next_multiple_of(4)))
    };
    let (kind, json, mut next) = chunk(HEADER)?;
    if kind != JSON {
        let what = "the first chunk is not JSON, as it must be; export the mesh again";
        return Err(source.malformed(Place::Byte(HEADER + 4), what));
    }
    let mut binary = None;
    while next < bytes.len() && binary.is_none() {
        let (kind, body, after) = chunk(next)?;
        binary = (kind == BIN).then_some(body);
        next = after;
    }
    fill(json, binary, source, mesh)
}

/// Reads a text that [`is_document`].
pub(super) fn read_document(bytes: &[u8], mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    fill(text, None, Source(MeshFormat::Gltf), mesh)
}

fn fill(
    json: &[u8],
    binary: Option<&[u8]>,
    source: Source,
    mut mesh: Builder<'_>,
) -> Result<RawMesh, ReadError> {
    let document: Document<'_> = serde_json::from_slice(json).map_err(|fault| {
        let what = format!("the JSON cannot be used: {fault}; export the mesh again");
        source.malformed(Place::Line(fault.line()), what)
    })?;
    if !document.asset.version.starts_with("2.") {
        let what = format!(
            "this is glTF version {}, but only version 2 can be read; export the mesh again",
            shown(document.asset.version.as_bytes())
        );
        return Err(source.malformed(Place::Item("asset", 0), what));
    }
    let needed = document.extensions_required.0.iter().enumerate();
    for (index, name) in needed {
        if !HARMLESS.iter().any(|harmless| name.starts_with(harmless)) {
            let kind = match &**name {
                "KHR_draco_mesh_compression" => ", Draco compression",
                "EXT_meshopt_compression" | "KHR_meshopt_compression" => ", meshopt compression",
                _ => "",
            };
            let what = format!(
                "it requires the extension {}{kind}, which cannot be read; export the mesh without it, uncompressed",
                shown(name.as_bytes())
            );
            return Err(source.malformed(item("extensionsRequired", index as u32), what));
        }
    }
    let buffers = buffers(&document, binary, source)?;
    let accessors = Accessors::new(&document, buffers, source);
    let scene = Scene {
        document: &document,
        accessors: &accessors,
        source,
    };
    scene.fill(&mut mesh)?;
    mesh.finish()
}

fn buffers<'a>(
    document: &'a Document<'a>,
    binary: Option<&'a [u8]>,
    source: Source,
) -> Result<Vec<Cow<'a, [u8]>>, ReadError> {
    let buffers = document.buffers.0.iter().enumerate();
    let read = buffers.map(|(index, buffer)| {
        let wrong = |what: String| source.malformed(item("buffers", index as u32), what);
        let bytes: Cow<[u8]> = match (&buffer.uri, binary) {
            (Some(uri), _) => Cow::Owned(embedded(uri).map_err(wrong)?),
            (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
            (None, _) => {
                return Err(wrong(
                    "its bytes are not in the file; send it as GLB".to_owned(),
                ));
            }
        };
        if (bytes.len() as u64) < buffer.byte_length {
            return Err(wrong(format!(
                "it promises {} bytes, but only {} are there; send the whole file",
                buffer.byte_length,
                bytes.len()
            )));
        }
        Ok(bytes)
    });
    read.collect()
}

/// The bytes of a `data:` URI.
fn embedded(uri: &str) -> Result<Vec<u8>, String> {
    let Some(data) = uri.strip_prefix("data:") else {
        return Err(format!(
            "its bytes are in another file, `{}`, which is never opened; send one file that contains everything, \
             such as GLB",
            shown(uri.as_bytes())
        ));
    };
    let Some((_, text)) = data.split_once(";base64,") else {
        return Err("its data URI is not base64; export the mesh again".to_owned());
    };
    let padded = text.ends_with('=');
    let engine = if padded { &STANDARD } else { &STANDARD_NO_PAD };
    let bytes = engine.decode(text);
    bytes.map_err(|fault| format!("its base64 is broken: {fault}; export the mesh again"))
}
