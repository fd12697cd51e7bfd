//! Which format a file has, by its content, and the table of the readers.
//!
//! Names and media types of uploads are often wrong, so the content decides; what the sender declares only settles
//! doubts, and a declaration that contradicts the content is an error. [`READERS`] lists the kinds of files with
//! their tests, and the first whose test holds reads the file. The order is that of certainty:
//!
//! 1. A magic word at the start (GLB, PLY) settles it, and so does a model in a zip archive (3MF).
//! 2. Binary STL has no magic word, but its length follows from the count in its header. This is tried before any text
//!    format, because many writers begin the free-form header with the word `solid`, as ASCII STL does. No text
//!    passes for binary: as a count, four printable characters promise at least 7 GB.
//! 3. Text formats are distinguished by their first words, COLLADA by the root of its XML. glTF comes last, since finding its key may take a pass over
//!    the file.
//! 4. What is no text may still be the beginning of a binary STL file; its reader then says how much is missing.
//!
//! Before any of these, a file that [`foreign`] knows is refused by its name.
//!
//! **Cost:** one pass over the bytes at most for each test, and the tests of text formats end at the first word that
//! does not fit. A new format is a file with a test and a reader, a line here, and a variant of [`MeshFormat`].

use graspd_core::mesh::RawMesh;

use crate::builder::Builder;
use crate::{MeshFormat, ReadError, dae, foreign, gltf, obj, off, ply, stl, threemf};

/// How one kind of file is recognised and read.
pub(super) struct Reader {
    pub(super) format: MeshFormat,
    recognises: fn(&Content<'_>) -> bool,
    /// Reads a file that was recognised.
    pub(super) read: fn(&[u8], Builder<'_>) -> Result<RawMesh, ReadError>,
}

/// Every kind of file, in the order in which they are tried.
static READERS: [Reader; 10] = [
    Reader {
        format: MeshFormat::Glb,
        recognises: |content| gltf::is_binary(content.bytes),
        read: gltf::read_binary,
    },
    Reader {
        format: MeshFormat::ThreeMf,
        recognises: |content| {
            threemf::is_model(content.bytes, content.is_declared(MeshFormat::ThreeMf))
        },
        read: threemf::read,
    },
    Reader {
        format: MeshFormat::Ply,
        recognises: |content| ply::begins(content.bytes),
        read: ply::read,
    },
    Reader {
        format: MeshFormat::Stl,
        recognises: |content| stl::binary::fits(content.bytes),
        read: stl::binary::read,
    },
    Reader {
        format: MeshFormat::Stl,
        recognises: |content| content.is_text && stl::ascii::begins(content.bytes),
        read: stl::ascii::read,
    },
    Reader {
        format: MeshFormat::Dae,
        recognises: |content| content.is_text && dae::begins(content.bytes),
        read: dae::read,
    },
    Reader {
        format: MeshFormat::Off,
        recognises: |content| {
            content.is_text && off::begins(content.bytes, content.is_declared(MeshFormat::Off))
        },
        read: off::read,
    },
    Reader {
        format: MeshFormat::Obj,
        recognises: |content| {
            content.is_text && obj::begins(content.bytes, content.is_declared(MeshFormat::Obj))
        },
        read: obj::read,
    },
    Reader {
        format: MeshFormat::Gltf,
        recognises: |content| content.is_text && gltf::is_document(content.bytes),
        read: gltf::read_document,
    },
    Reader {
        format: MeshFormat::Stl,
        recognises: |content| {
            let declared = content.is_declared(MeshFormat::Stl);
            !content.is_text
                && stl::binary::is_cut_short(content.bytes, declared)
                && !is_utf16(content.bytes)
        },
        read: stl::binary::read,
    },
];

/// Binary data of any length shows a NUL byte this early in practice, and text never does.
const TEXT_WINDOW: usize = 1024;

/// A file that is to be recognised.
struct Content<'a> {
    bytes: &'a [u8],
    /// What the sender says it is.
    declared: Option<MeshFormat>,
    is_text: bool,
}

impl Content<'_> {
    fn is_declared(&self, format: MeshFormat) -> bool {
        self.declared == Some(format)
    }
}

/// Finds the reader of a file.
///
/// # Errors
/// [`ReadError::NotAMesh`] when there is none, or when the sender `declared` another format.
pub(super) fn reader(
    bytes: &[u8],
    declared: Option<MeshFormat>,
) -> Result<&'static Reader, ReadError> {
    let not_a_mesh = |why: String| ReadError::NotAMesh { why };
    if bytes.is_empty() {
        return Err(not_a_mesh("the file is empty".into()));
    }
    let content = Content {
        bytes,
        declared,
        is_text: bytes.iter().take(TEXT_WINDOW).all(|&b| b != 0),
    };
    // The free header of a whole binary STL file may begin with anything.
    if let Some(kind) = foreign::kind(bytes).filter(|_| !stl::binary::fits(bytes)) {
        return Err(not_a_mesh(format!("it is {}: {}", kind.name, kind.advice)));
    }
    let found = READERS.iter().find(|reader| (reader.recognises)(&content));
    match (found, declared) {
        (None, _) if is_utf16(bytes) => Err(not_a_mesh(
            "it is UTF-16 text, and mesh files are ASCII or UTF-8: save it as UTF-8".into(),
        )),
        (None, _) if let Some(archive) = threemf::other_archive(bytes) => {
            Err(not_a_mesh(format!("it is {archive}")))
        }
        (None, Some(declared)) => Err(not_a_mesh(format!(
            "it was sent as {declared}, but its content is not {declared}"
        ))),
        (None, None) => Err(not_a_mesh("its content matches none of them".into())),
        (Some(found), Some(declared)) if declared != found.format => Err(not_a_mesh(format!(
            "it was sent as {declared}, but its content is {}: leave the format out or correct it",
            found.format
        ))),
        (Some(found), _) => Ok(found),
    }
}

/// Whether bytes are UTF-16 text: with a byte-order mark, or with every other of the first six bytes zero.
fn is_utf16(bytes: &[u8]) -> bool {
    matches!(bytes, [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..])
        || matches!(bytes, [a, 0, b, 0, c, 0, ..] | [0, a, 0, b, 0, c, ..]
            if [a, b, c].iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace()))
}
