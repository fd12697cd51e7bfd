//! The elements of a COLLADA document that matter for its triangles.
//!
//! An element is a few indices into the text, which stays where it is: its tag, its contents, its first child and the
//! element behind it. Elements of other names are skipped with all that is in them.

use std::borrow::Cow;
use std::collections::HashMap;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::malformed;
use crate::builder::Builder;
use crate::text::{not_a_number, shown};
use crate::xml::{self, DOCUMENT_TYPE, attribute};
use crate::{Place, ReadError};

/// The elements that are kept, by their names in the specification.
const KEPT: [&str; 39] = [
    "COLLADA",
    "accessor",
    "bind_shape_matrix",
    "controller",
    "float_array",
    "geometry",
    "h",
    "input",
    "instance_controller",
    "instance_geometry",
    "instance_node",
    "instance_visual_scene",
    "library_controllers",
    "library_geometries",
    "library_nodes",
    "library_visual_scenes",
    "lookat",
    "matrix",
    "mesh",
    "morph",
    "node",
    "p",
    "ph",
    "polygons",
    "polylist",
    "rotate",
    "scale",
    "scene",
    "skew",
    "skin",
    "source",
    "technique_common",
    "translate",
    "triangles",
    "trifans",
    "tristrips",
    "vcount",
    "vertices",
    "visual_scene",
];

/// No element.
const NONE: u32 = u32::MAX;

/// An element of the text.
struct Entry<'a> {
    name: &'a str,
    /// The name with the attributes behind it.
    tag: &'a str,
    /// Where its contents begin and end.
    begin: usize,
    end: usize,
    first_child: u32,
    next: u32,
}

/// The elements of a document.
pub(super) struct Tree<'a> {
    text: &'a str,
    entries: Vec<Entry<'a>>,
    ids: HashMap<Cow<'a, str>, u32>,
}

/// An element of a [`Tree`].
#[derive(Clone, Copy)]
pub(super) struct Element<'t> {
    tree: &'t Tree<'t>,
    pub(super) index: u32,
}

impl<'a> Tree<'a> {
    /// Splits a document into its elements, which count against the limit on memory.
    pub(super) fn parse(text: &'a str, mesh: &mut Builder<'_>) -> Result<Self, ReadError> {
        let mut tree = Self {
            text,
            entries: Vec::new(),
            ids: HashMap::new(),
        };
        let mut reader = Reader::from_str(text);
        // The elements that are open, each with its last child.
        let mut open: Vec<(u32, u32)> = Vec::new();
        loop {
            let event = reader.read_event().map_err(|fault| {
                malformed(
                    Place::Byte(reader.error_position() as usize),
                    xml::fault(&fault),
                )
            })?;
            let at = reader.buffer_position() as usize;
            match event {
                Event::Start(tag) if !is_kept(&tag) => {
                    let name = tag.to_end().into_owned();
                    reader.read_to_end(name.name()).map_err(|fault| {
                        malformed(
                            Place::Byte(reader.error_position() as usize),
                            xml::fault(&fault),
                        )
                    })?;
                }
                Event::Start(tag) => {
                    let entry = tree.entry(&tag, at - 1, at);
                    let index = tree.add(entry, &mut open, mesh)?;
                    open.push((index, NONE));
                }
                Event::Empty(tag) if is_kept(&tag) => {
                    let entry = tree.entry(&tag, at - 2, at);
                    tree.add(entry, &mut open, mesh)?;
                }
                Event::End(_) => {
                    let end = text[..at].rfind("</").unwrap_or(at);
                    if let Some((index, _)) = open.pop() {
                        tree.entries[index as usize].end = end;
                    }
                }
                Event::DocType(_) => return Err(malformed(Place::Byte(at), DOCUMENT_TYPE)),
                Event::Eof => break,
                _ => {}
            }
        }
        match open.is_empty() {
            true => Ok(tree),
            false => Err(malformed(
                Place::Byte(text.len()),
                "the file ends inside an element; send the whole file",
            )),
        }
    }

    /// The entry of a tag whose attributes end at `end` and whose contents begin at `begin`.
    fn entry(&self, tag: &BytesStart<'_>, end: usize, begin: usize) -> Entry<'a> {
        let tag_text = &self.text[end - tag.len()..end];
        Entry {
            name: &tag_text[..tag.name().0.len()],
            tag: tag_text,
            begin,
            end: begin,
            first_child: NONE,
            next: NONE,
        }
    }

    fn add(
        &mut self,
        entry: Entry<'a>,
        open: &mut [(u32, u32)],
        mesh: &mut Builder<'_>,
    ) -> Result<u32, ReadError> {
        let index = self.entries.len();
        let ids = self.ids.len() * 2 * size_of::<(Cow<'_, str>, u32)>();
        mesh.check_memory(
            index,
            self.entries.capacity() * size_of::<Entry<'_>>() + ids,
        )?;
        let index = index as u32;
        if let Some((parent, last)) = open.last_mut() {
            match *last {
                NONE => self.entries[*parent as usize].first_child = index,
                last => self.entries[last as usize].next = index,
            }
            *last = index;
        }
        let tag = BytesStart::from_content(entry.tag, entry.name.len());
        if let Some(id) = attribute(&tag, "id") {
            self.ids.entry(Cow::Owned(id.into_owned())).or_insert(index);
        }
        self.entries.push(entry);
        Ok(index)
    }

    /// Returns the root element.
    pub(super) fn root(&'a self) -> Option<Element<'a>> {
        (!self.entries.is_empty()).then_some(Element {
            tree: self,
            index: 0,
        })
    }
}

fn is_kept(tag: &BytesStart<'_>) -> bool {
    KEPT.binary_search(&tag.local_name().into_inner()).is_ok()
}

impl<'t> Element<'t> {
    fn entry(&self) -> &'t Entry<'t> {
        &self.tree.entries[self.index as usize]
    }

    /// Returns the name without a prefix.
    pub(super) fn name(&self) -> &'t str {
        let name = self.entry().name;
        name.rsplit_once(':').map_or(name, |(_, local)| local)
    }

    /// Returns where it stands in the file.
    pub(super) fn place(&self) -> Place {
        Place::Byte(self.entry().begin)
    }

    /// Returns the value of an attribute.
    pub(super) fn attribute(&self, name: &str) -> Option<Cow<'t, str>> {
        let entry = self.entry();
        let tag = BytesStart::from_content(entry.tag, entry.name.len());
        attribute(&tag, name).map(|value| Cow::Owned(value.into_owned()))
    }

    /// Returns the value of an attribute that is a whole number; `or` where there is none.
    pub(super) fn number(&self, name: &str, or: usize) -> Result<usize, ReadError> {
        let Some(text) = self.attribute(name) else {
            return Ok(or);
        };
        text.trim().parse().map_err(|_| {
            let what = format!(
                "{name} `{}` is not a whole number; export the mesh again",
                shown(text.as_bytes())
            );
            malformed(self.place(), what)
        })
    }

    /// Returns the children, in their order.
    pub(super) fn children(&self) -> impl Iterator<Item = Element<'t>> + use<'t> {
        let tree = self.tree;
        let element = move |index: u32| (index != NONE).then_some(Element { tree, index });
        std::iter::successors(element(self.entry().first_child), move |child| {
            element(child.entry().next)
        })
    }

    /// Returns the first child of that name.
    pub(super) fn child(&self, name: &str) -> Option<Element<'t>> {
        self.children().find(|child| child.name() == name)
    }

    /// Returns the element whose id an attribute refers to, which must be in this file and have that name.
    pub(super) fn target(&self, name: &str, kind: &str) -> Result<Element<'t>, ReadError> {
        let url = self.attribute(name).unwrap_or_default();
        let wrong = |what: String| malformed(self.place(), what);
        let Some(id) = url.trim().strip_prefix('#') else {
            return Err(wrong(format!(
                "<{}> refers to `{}`, another file, which is never opened; export one file that contains everything",
                self.name(),
                shown(url.as_bytes())
            )));
        };
        let found = self.tree.ids.get(id).map(|&index| Element {
            tree: self.tree,
            index,
        });
        found.filter(|found| found.name() == kind).ok_or_else(|| {
            wrong(format!(
                "<{}> refers to `{}`, but there is no {kind} of that id; send the whole file or export it again",
                self.name(),
                shown(id.as_bytes())
            ))
        })
    }

    /// Returns the numbers in the text of an element.
    pub(super) fn values<T: std::str::FromStr>(
        &self,
    ) -> impl Iterator<Item = Result<T, ReadError>> + use<'t, T> {
        let entry = self.entry();
        let text = &self.tree.text[entry.begin..entry.end];
        let element = *self;
        text.split_ascii_whitespace().map(move |word| {
            word.parse().map_err(|_| {
                let at = word.as_ptr() as usize - element.tree.text.as_ptr() as usize;
                malformed(Place::Byte(at), not_a_number(word.as_bytes(), "a number"))
            })
        })
    }
}
