//! Telling the supported formats apart by their content.

use super::text::{Lines, fields, number};
use super::{MeshFormat, ReadError, gltf, off, stl};

/// What the content turned out to be; STL is two formats under one name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    StlBinary,
    StlAscii,
    Obj,
    Ply,
    Off,
    Glb,
    Gltf,
}

impl Kind {
    pub(super) fn format(self) -> MeshFormat {
        match self {
            Self::StlBinary | Self::StlAscii => MeshFormat::Stl,
            Self::Obj => MeshFormat::Obj,
            Self::Ply => MeshFormat::Ply,
            Self::Off => MeshFormat::Off,
            Self::Glb => MeshFormat::Glb,
            Self::Gltf => MeshFormat::Gltf,
        }
    }
}

/// Binary data of any length shows a NUL byte this early in practice, and text never does.
const TEXT_WINDOW: usize = 1024;

/// Statements that an OBJ file may begin with.
const OBJ_STATEMENTS: [&[u8]; 15] = [
    b"v", b"vt", b"vn", b"vp", b"f", b"o", b"g", b"s", b"l", b"p", b"mtllib", b"usemtl", b"mg",
    b"cstype", b"lod",
];

/// Recognises the content, in one pass at most.
pub(super) fn detect(bytes: &[u8], said: Option<MeshFormat>) -> Result<Kind, ReadError> {
    let not_a_mesh = |why: String| ReadError::NotAMesh { why };
    if bytes.is_empty() {
        return Err(not_a_mesh("the file is empty".into()));
    }
    let Some(found) = recognise(bytes, said) else {
        let why = if is_utf16(bytes) {
            "it is UTF-16 text, and mesh files are ASCII or UTF-8: save it so".into()
        } else {
            match said {
                Some(said) => format!("it was sent as {said}, but its content is not {said}"),
                None => "its content is of none of them".into(),
            }
        };
        return Err(not_a_mesh(why));
    };
    match said {
        Some(said) if said != found.format() => Err(not_a_mesh(format!(
            "it was sent as {said}, but its content is {}: leave the format out or correct it",
            found.format()
        ))),
        _ => Ok(found),
    }
}

fn recognise(bytes: &[u8], said: Option<MeshFormat>) -> Option<Kind> {
    if gltf::is_binary(bytes) {
        return Some(Kind::Glb);
    }
    if Lines::new(bytes)
        .next()
        .is_some_and(|(_, line)| fields(line).eq([b"ply"]))
    {
        return Some(Kind::Ply);
    }
    // The length decides before the word `solid` does: many writers of binary files begin their
    // free-form header with it. Text cannot pass for binary, because its bytes 80 to 83 read as
    // a count promise at least 7 GB.
    if stl::binary::fits(bytes) {
        return Some(Kind::StlBinary);
    }
    if bytes.iter().take(TEXT_WINDOW).all(|&b| b != 0) {
        if is_ascii_stl(bytes) {
            return Some(Kind::StlAscii);
        }
        if off::begins(bytes, said == Some(MeshFormat::Off)) {
            return Some(Kind::Off);
        }
        if is_obj(bytes) {
            return Some(Kind::Obj);
        }
        return gltf::is_document(bytes).then_some(Kind::Gltf);
    }
    (stl::binary::is_cut_short(bytes, said == Some(MeshFormat::Stl)) && !is_utf16(bytes))
        .then_some(Kind::StlBinary)
}

fn is_ascii_stl(bytes: &[u8]) -> bool {
    let mut words = Lines::new(bytes)
        .flat_map(|(_, line)| fields(line))
        .map(|word| word.to_ascii_lowercase());
    match words.next().as_deref() {
        Some(b"facet") => words.next().as_deref() == Some(b"normal"),
        Some(b"solid") => words.any(|word| word == b"facet" || word == b"endsolid"),
        _ => false,
    }
}

/// The first statement is one of OBJ's, and somewhere there is a vertex or face with a number.
fn is_obj(bytes: &[u8]) -> bool {
    let mut statements = Lines::new(bytes)
        .map(|(_, line)| fields(line))
        .filter_map(|mut words| Some((words.next()?, words.next())))
        .filter(|(keyword, _)| !keyword.starts_with(b"#"))
        .peekable();
    statements
        .peek()
        .is_some_and(|(keyword, _)| OBJ_STATEMENTS.contains(keyword))
        && statements.any(|(keyword, first)| {
            let first = first.unwrap_or_default();
            match keyword {
                b"v" => number(first).is_some(),
                b"f" => first
                    .split(|&b| b == b'/')
                    .next()
                    .and_then(number)
                    .is_some(),
                _ => false,
            }
        })
}

fn is_utf16(bytes: &[u8]) -> bool {
    matches!(bytes, [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..])
        || matches!(bytes, [a, 0, b, 0, c, 0, ..] | [0, a, 0, b, 0, c, ..]
            if [a, b, c].iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace()))
}
