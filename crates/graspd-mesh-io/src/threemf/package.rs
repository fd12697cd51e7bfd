//! The zip archive of a 3MF file, of which nothing is believed.

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, Cursor, Read};

use quick_xml::Reader;
use quick_xml::events::Event;
use zip::ZipArchive;
use zip::result::ZipError;

use super::model::{self, Model};
use super::{MAX_RATIO, MIN_BUDGET, malformed};
use crate::builder::Builder;
use crate::text::shown;
use crate::xml::{self, DOCUMENT_TYPE, attribute};
use crate::{Place, ReadError};

/// The most bytes of one tag or text.
const MAX_EVENT: usize = 1 << 20;

/// How the files begin that zip writes.
const ZIP: &[u8] = b"PK\x03\x04";

fn has_model(names: &[String]) -> bool {
    names
        .iter()
        .any(|name| name.to_ascii_lowercase().ends_with(".model"))
}

/// Whether a file is a zip archive with a model in it, or may be the beginning of one: a sender who `declared` 3MF is
/// believed.
pub(in super::super) fn is_model(bytes: &[u8], declared: bool) -> bool {
    if !bytes.starts_with(ZIP) {
        return false;
    }
    match names(bytes) {
        Some(names) => has_model(&names),
        // The names of the first entries stand at the beginning of the file.
        None => {
            let beginning = &bytes[..bytes.len().min(1 << 16)];
            let mut at = beginning.windows(3);
            declared
                || at.any(|word| word == b"3D/")
                || beginning.windows(6).any(|word| word == b"_rels/")
        }
    }
}

/// What a zip archive is that holds no model, and what to do with it; `None` for other files.
pub(in super::super) fn other_archive(bytes: &[u8]) -> Option<String> {
    let names = bytes
        .starts_with(ZIP)
        .then(|| names(bytes).unwrap_or_default())?;
    let is = |name: &&String, endings: &[&str]| {
        let name = name.to_ascii_lowercase();
        endings.iter().any(|ending| name.ends_with(ending))
    };
    let first = names.first();
    if first.is_some_and(|name| is(&name, &[".usd", ".usda", ".usdc"])) {
        return Some("a USDZ file: export the body as GLB, as from Blender or usdview".to_owned());
    }
    let mesh = names.iter().find(|name| {
        is(
            name,
            &[".stl", ".obj", ".ply", ".off", ".glb", ".gltf", ".dae"],
        )
    });
    Some(match mesh {
        Some(name) => format!(
            "a zip archive: unpack it and send the mesh file in it, such as {}",
            shown(name.as_bytes())
        ),
        None => "a zip archive: unpack it and send the mesh file in it".to_owned(),
    })
}

/// The names of the entries, or `None` when the archive cannot be opened.
fn names(bytes: &[u8]) -> Option<Vec<String>> {
    let archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let names = archive.file_names_raw();
    Some(
        names
            .map(|name| String::from_utf8_lossy(name).into_owned())
            .collect(),
    )
}

/// An open archive.
pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    /// The number of each entry, by its name in lower case, as names that differ in case alone name one part.
    entries: HashMap<String, usize>,
    /// How many more bytes may be unpacked.
    budget: u64,
}

impl<'a> Package<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|fault| {
            let what = format!("its zip archive cannot be opened: {fault}; send the whole file");
            malformed(Place::Byte(bytes.len()), what)
        })?;
        let names = archive.file_names_raw().enumerate();
        let names =
            names.map(|(at, name)| (String::from_utf8_lossy(name).to_ascii_lowercase(), at));
        Ok(Self {
            entries: names.collect(),
            budget: (bytes.len() as u64)
                .saturating_mul(MAX_RATIO)
                .max(MIN_BUDGET),
            archive,
        })
    }

    /// Returns the path of the model that the package is about.
    pub(super) fn root_model(&mut self) -> Result<String, ReadError> {
        const USUAL: &str = "3d/3dmodel.model";
        let mut found = None;
        if self.entries.contains_key("_rels/.rels") {
            self.events("_rels/.rels", |event| {
                if let Event::Start(tag) | Event::Empty(tag) = &event
                    && tag.local_name().into_inner() == "Relationship"
                    && attribute(tag, "Type").is_some_and(|kind| kind.ends_with("/3dmodel"))
                    && found.is_none()
                {
                    found = attribute(tag, "Target").map(|target| path(&target));
                }
                Ok(())
            })?;
        }
        let any = || {
            let mut models: Vec<&String> = self
                .entries
                .keys()
                .filter(|name| name.ends_with(".model"))
                .collect();
            models.sort();
            models.first().map(|name| (*name).clone())
        };
        let usual = self.entries.contains_key(USUAL).then(|| USUAL.to_owned());
        let found = found.filter(|path| self.entries.contains_key(path));
        found.or(usual).or_else(any).ok_or_else(|| {
            malformed(
                Place::Byte(0),
                "there is no model in the archive; export the mesh again",
            )
        })
    }

    /// Reads the model at `path`; `memory` is what the models take that were read before it.
    pub(super) fn model(
        &mut self,
        path: &str,
        memory: usize,
        mesh: &mut Builder<'_>,
    ) -> Result<Model, ReadError> {
        let mut parser = model::Parser::new(memory, mesh);
        self.events(path, |event| parser.event(event))?;
        Ok(parser.finish())
    }

    /// Calls `each` with every event of an entry.
    fn events(
        &mut self,
        path: &str,
        mut each: impl FnMut(Event<'_>) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let budget = self.budget;
        let shown_path = shown(path.as_bytes());
        let missing = || {
            let what = format!(
                "{shown_path} is referred to, but is not in the archive; export the mesh again"
            );
            malformed(Place::Byte(0), what)
        };
        let index = *self.entries.get(path).ok_or_else(missing)?;
        let entry = self.archive.by_index(index).map_err(|fault| {
            let what = match fault {
                ZipError::CompressionMethodNotSupported(_) => {
                    format!(
                        "{shown_path} is packed by another method than deflate; pack the file again"
                    )
                }
                fault => format!("{shown_path} cannot be unpacked: {fault}; send the whole file"),
            };
            malformed(Place::Byte(0), what)
        })?;
        let source = Bounded {
            inner: BufReader::new(entry),
            left: budget,
            event: 0,
        };
        let mut reader = Reader::from_reader(source);
        let mut buffer = Vec::new();
        let mut depth = 0_usize;
        loop {
            buffer.clear();
            reader.get_mut().event = 0;
            let event = reader.read_event_into(&mut buffer).map_err(|fault| {
                let what = match fault {
                    quick_xml::Error::Io(fault) if fault.kind() == io::ErrorKind::FileTooLarge => {
                        fault.to_string()
                    }
                    fault => format!("in {shown_path} {}", xml::fault(&fault)),
                };
                malformed(Place::Unpacked(reader.error_position() as usize), what)
            })?;
            let at = Place::Unpacked(reader.buffer_position() as usize);
            match event {
                Event::Start(_) => depth += 1,
                Event::End(_) => depth = depth.saturating_sub(1),
                Event::DocType(_) => return Err(malformed(at, DOCUMENT_TYPE)),
                Event::Eof if depth > 0 => {
                    let what =
                        format!("{shown_path} ends inside an element; export the mesh again");
                    return Err(malformed(at, what));
                }
                Event::Eof => break,
                _ => {}
            }
            each(event)?;
        }
        self.budget = reader.get_ref().left;
        Ok(())
    }
}

/// The path of a part as it stands in [`Package::entries`].
pub(super) fn path(target: &str) -> String {
    target.trim_start_matches('/').to_ascii_lowercase()
}

/// Fails when more bytes are read than are left, or more than one tag or text may have.
struct Bounded<R> {
    inner: R,
    left: u64,
    /// Bytes since the last event ended.
    event: usize,
}

impl<R: BufRead> Bounded<R> {
    fn check(&self) -> io::Result<()> {
        let what = match (self.left, self.event) {
            (0, _) => format!(
                "the archive unpacks to more than {MAX_RATIO} times its size, as no mesh does; export it again"
            ),
            (_, MAX_EVENT..) => format!(
                "one tag or text has more than {MAX_EVENT} bytes, as none of a mesh has; export it again"
            ),
            _ => return Ok(()),
        };
        Err(io::Error::new(io::ErrorKind::FileTooLarge, what))
    }
}

impl<R: BufRead> BufRead for Bounded<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.check()?;
        self.inner.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.left = self.left.saturating_sub(amount as u64);
        self.event += amount;
        self.inner.consume(amount);
    }
}

impl<R: BufRead> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}
