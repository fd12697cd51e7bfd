//! The objects and build items of one model, from the events of its XML.

use std::collections::HashMap;

use nalgebra::{Matrix4, Point3};
use quick_xml::XmlVersion;
use quick_xml::events::attributes::Attribute;
use quick_xml::events::{BytesStart, Event};

use super::malformed;
use super::package::path;
use crate::builder::Builder;
use crate::instance::{MAX_INSTANCES, Shape};
use crate::text::{not_a_number, shown};
use crate::xml::attribute;
use crate::{Place, ReadError};

/// Namespaces of extensions that a file may require because they are read, or because they change no triangle.
const HARMLESS: [&str; 4] = [
    "http://schemas.microsoft.com/3dmanufacturing/core/",
    "http://schemas.microsoft.com/3dmanufacturing/production/",
    "http://schemas.microsoft.com/3dmanufacturing/material/",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/",
];

/// An object, which may consist of triangles and of other objects.
#[derive(Default)]
pub(super) struct Object {
    pub(super) name: String,
    /// Whether it only supports others in a printer.
    pub(super) is_support: bool,
    pub(super) shape: Shape,
    pub(super) components: Vec<Reference>,
}

/// An object with the transform that places it.
pub(super) struct Reference {
    pub(super) object: u32,
    /// The model that has the object, if it is another one.
    pub(super) path: Option<String>,
    pub(super) transform: Matrix4<f64>,
}

/// The contents of a model.
#[derive(Default)]
pub(super) struct Model {
    pub(super) objects: HashMap<u32, Object>,
    items: Vec<Reference>,
}

impl Model {
    /// Returns what is to be built; all objects that are no components where the file does not say.
    pub(super) fn roots(&self) -> impl Iterator<Item = &Reference> {
        self.items.iter()
    }

    /// Returns the other models that this one refers to.
    pub(super) fn paths(&self) -> Vec<String> {
        let components = self.objects.values().flat_map(|object| &object.components);
        let references = self.items.iter().chain(components);
        let mut paths: Vec<String> = references
            .filter_map(|reference| reference.path.clone())
            .collect();
        paths.sort();
        paths.dedup();
        paths
    }

    /// Returns about how many bytes of memory it takes.
    pub(super) fn memory(&self) -> usize {
        let of = |object: &Object| {
            object.shape.memory()
                + object.components.capacity() * size_of::<Reference>()
                + size_of::<Object>()
        };
        self.objects.values().map(of).sum::<usize>()
            + self.items.capacity() * size_of::<Reference>()
    }
}

/// Collects a model from its events.
pub(super) struct Parser<'m, 'p> {
    model: Model,
    /// The object that is open, and its id.
    open: Option<(u32, Object)>,
    /// The prefix of the core namespace, as the root element has it.
    prefix: Option<String>,
    /// Vertices, triangles and references so far.
    entries: usize,
    references: usize,
    /// The bytes of the models before this one and of the objects that have ended.
    memory: usize,
    mesh: &'m mut Builder<'p>,
}

impl<'m, 'p> Parser<'m, 'p> {
    pub(super) fn new(memory: usize, mesh: &'m mut Builder<'p>) -> Self {
        Self {
            model: Model::default(),
            open: None,
            prefix: None,
            entries: 0,
            references: 0,
            memory,
            mesh,
        }
    }

    pub(super) fn finish(mut self) -> Model {
        if self.model.items.is_empty() {
            self.model.items = self.unreferenced();
        }
        self.model
    }

    /// The objects that are no components, in the order of their ids.
    fn unreferenced(&self) -> Vec<Reference> {
        let objects = &self.model.objects;
        let components = objects.values().flat_map(|object| &object.components);
        let used: std::collections::HashSet<u32> =
            components.map(|reference| reference.object).collect();
        let mut ids: Vec<u32> = objects
            .keys()
            .copied()
            .filter(|id| !used.contains(id))
            .collect();
        ids.sort_unstable();
        let item = |object| Reference {
            object,
            path: None,
            transform: Matrix4::identity(),
        };
        ids.into_iter().map(item).collect()
    }

    pub(super) fn event(&mut self, event: Event<'_>) -> Result<(), ReadError> {
        match event {
            Event::Start(tag) => self.tag(&tag),
            Event::Empty(tag) => {
                self.tag(&tag)?;
                self.end(tag.name().into_inner());
                Ok(())
            }
            Event::End(tag) => {
                self.end(tag.name().into_inner());
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// The name of an element of the core namespace.
    fn own<'n>(&self, name: &'n str) -> Option<&'n str> {
        let (prefix, local) = name.rsplit_once(':').unwrap_or(("", name));
        (self.prefix.as_deref() == Some(prefix)).then_some(local)
    }

    fn tag(&mut self, tag: &BytesStart<'_>) -> Result<(), ReadError> {
        let name = tag.name();
        if self.prefix.is_none() {
            let (prefix, local) = name.0.rsplit_once(':').unwrap_or(("", name.0));
            if local != "model" {
                let what = format!(
                    "its model begins with <{}>; export the mesh again",
                    shown(name.0.as_bytes())
                );
                return Err(malformed(Place::Unpacked(0), what));
            }
            self.prefix = Some(prefix.to_owned());
        }
        match self.own(name.0) {
            Some("model") => check_extensions(tag),
            Some("object") => self.object(tag),
            Some("vertex") => self.vertex(tag),
            Some("triangle") => self.triangle(tag),
            Some("component") => {
                let component = self.reference(tag)?;
                if let Some((_, object)) = &mut self.open {
                    object.components.push(component);
                }
                Ok(())
            }
            Some("item") => {
                let item = self.reference(tag)?;
                self.model.items.push(item);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn end(&mut self, name: &str) {
        if self.own(name) == Some("object")
            && let Some((id, object)) = self.open.take()
        {
            self.memory += object.shape.memory();
            self.model.objects.insert(id, object);
        }
    }

    fn object(&mut self, tag: &BytesStart<'_>) -> Result<(), ReadError> {
        let id = self.id(tag, "id")?;
        if self.open.is_some() || self.model.objects.contains_key(&id) {
            let what =
                "there is another object with its id, or one within it; export the mesh again";
            return Err(malformed(Place::Object(id), what));
        }
        self.count()?;
        let kind = attribute(tag, "type").unwrap_or_default();
        let name = attribute(tag, "name").unwrap_or_default();
        let object = Object {
            name: name.chars().take(256).collect(),
            is_support: matches!(&*kind, "support" | "solidsupport"),
            ..Object::default()
        };
        self.open = Some((id, object));
        Ok(())
    }

    fn vertex(&mut self, tag: &BytesStart<'_>) -> Result<(), ReadError> {
        let at = self.place();
        let position = values::<f64>(tag, ["x", "y", "z"], at, "a coordinate")?;
        self.count()?;
        if let Some((_, object)) = &mut self.open {
            object.shape.vertices.push(Point3::from(position));
        }
        Ok(())
    }

    fn triangle(&mut self, tag: &BytesStart<'_>) -> Result<(), ReadError> {
        let at = self.place();
        let corners = values::<u32>(tag, ["v1", "v2", "v3"], at, "a vertex number")?;
        self.count()?;
        if let Some((_, object)) = &mut self.open {
            object.shape.corners.extend(corners);
        }
        Ok(())
    }

    fn reference(&mut self, tag: &BytesStart<'_>) -> Result<Reference, ReadError> {
        self.count()?;
        self.references += 1;
        let object = self.id(tag, "objectid")?;
        let at = Place::Object(object);
        if self.references > MAX_INSTANCES {
            let what = format!(
                "the file has more than {MAX_INSTANCES} components and items; export the mesh again"
            );
            return Err(malformed(at, what));
        }
        let transform = match attribute(tag, "transform") {
            Some(text) => transform(&text, at)?,
            None => Matrix4::identity(),
        };
        Ok(Reference {
            object,
            path: attribute(tag, "path").map(|target| path(&target)),
            transform,
        })
    }

    /// Where the next fault is.
    fn place(&self) -> Place {
        self.open
            .as_ref()
            .map_or(Place::Unpacked(0), |(id, _)| Place::Object(*id))
    }

    fn id(&self, tag: &BytesStart<'_>, name: &str) -> Result<u32, ReadError> {
        let text = attribute(tag, name).unwrap_or_default();
        text.parse().map_err(|_| {
            let what = format!(
                "`{}` is not the {name} of an object; export the mesh again",
                shown(text.as_bytes())
            );
            malformed(self.place(), what)
        })
    }

    /// Counts one more vertex, triangle or reference against the limits.
    fn count(&mut self) -> Result<(), ReadError> {
        let open = self
            .open
            .as_ref()
            .map_or(0, |(_, object)| object.shape.memory());
        let references = self.references * size_of::<Reference>();
        self.mesh
            .check_memory(self.entries, self.memory + open + references)?;
        self.entries += 1;
        Ok(())
    }
}

/// Refuses a model that requires an extension which would change its triangles.
fn check_extensions(tag: &BytesStart<'_>) -> Result<(), ReadError> {
    let required = attribute(tag, "requiredextensions").unwrap_or_default();
    for prefix in required.split_ascii_whitespace() {
        let mut attributes = tag.attributes();
        let mut declared = attributes.with_checks(false).flatten();
        let declared =
            declared.find(|attribute| attribute.key.0.strip_prefix("xmlns:") == Some(prefix));
        let namespace = declared
            .map(|attribute| attribute.value.into_owned())
            .unwrap_or_default();
        if !HARMLESS
            .iter()
            .any(|harmless| namespace.starts_with(harmless))
        {
            let what = format!(
                "it requires the extension {prefix} ({}), which cannot be read; export the mesh without it",
                shown(namespace.as_bytes())
            );
            return Err(malformed(Place::Unpacked(0), what));
        }
    }
    Ok(())
}

/// The values of three attributes, found in one pass.
fn values<T: std::str::FromStr + Copy>(
    tag: &BytesStart<'_>,
    names: [&str; 3],
    at: Place,
    expected: &str,
) -> Result<[T; 3], ReadError> {
    let mut found = [None; 3];
    for attribute in tag.attributes().with_checks(false).flatten() {
        let Some(n) = names.iter().position(|&name| name == attribute.key.0) else {
            continue;
        };
        found[n] = Some(value(&attribute, at, expected)?);
    }
    match found {
        [Some(a), Some(b), Some(c)] => Ok([a, b, c]),
        _ => {
            let what = format!(
                "one of {} is missing from a <{}>; export the mesh again",
                names.join(", "),
                shown(tag.name().0.as_bytes())
            );
            Err(malformed(at, what))
        }
    }
}

fn value<T: std::str::FromStr>(
    attribute: &Attribute<'_>,
    at: Place,
    expected: &str,
) -> Result<T, ReadError> {
    let plain = attribute.value.trim_ascii().parse().ok();
    let read = || {
        attribute
            .normalized_value(XmlVersion::Implicit1_0)
            .ok()?
            .trim()
            .parse()
            .ok()
    };
    let value = plain.or_else(read);
    value.ok_or_else(|| malformed(at, not_a_number(attribute.value.as_bytes(), expected)))
}

/// A transform as twelve numbers: the images of the axes, then that of the origin.
fn transform(text: &str, at: Place) -> Result<Matrix4<f64>, ReadError> {
    let mut numbers = [0.0; 12];
    let mut words = text.split_ascii_whitespace();
    for number in &mut numbers {
        let word = words.next().unwrap_or_default();
        *number = word.parse().map_err(|_| {
            malformed(
                at,
                not_a_number(word.as_bytes(), "one of the twelve numbers of a transform"),
            )
        })?;
    }
    let mut matrix = Matrix4::identity();
    for (n, number) in numbers.into_iter().enumerate() {
        matrix[(n % 3, n / 3)] = number;
    }
    Ok(matrix)
}
