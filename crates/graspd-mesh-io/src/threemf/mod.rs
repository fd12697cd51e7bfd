//! 3MF (3D Manufacturing Format): a zip archive with a model in XML.
//!
//! ```text
//! _rels/.rels            names the model, usually 3D/3dmodel.model
//! 3D/3dmodel.model       objects with vertices and triangles or with other objects as components,
//!                        and the items to be built: objects, each with a transform
//! 3D/Objects/*.model     more objects, where the production extension is used
//! ```
//!
//! What comes out are the triangles of all build items in the frame and the unit of the file, transforms applied. An
//! object without triangles, or of a kind that only supports others in a printer, adds nothing.
//!
//! **Why a small file cannot become large:** entries are unpacked while they are read and never kept, all of them together
//! to at most [`MAX_RATIO`] times the file. What is kept are vertices and triangles, and those count against the limits of
//! the [builder](crate::builder::Builder), as do the copies that build items and components make of them. Documents that
//! declare entities are refused, an entry is read once, and no path leaves the archive.
//!
//! | file | subject |
//! |---|---|
//! | `package.rs` | the archive and its entries |
//! | `model.rs` | the objects and build items of one model |
//! | `mod.rs` | from the build items to the triangles |

mod model;
mod package;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use graspd_core::mesh::{RawMesh, WarningKind};
use nalgebra::Matrix4;

use self::model::{Model, Object, Reference};
use self::package::Package;
use super::builder::Builder;
use super::instance::MAX_INSTANCES;
use super::text::shown;
use super::{MeshFormat, Place, ReadError};

pub(super) use self::package::{is_model, other_archive};

/// Times the size of the file to which its entries may unpack. Models in XML shrink to a tenth or twentieth.
const MAX_RATIO: u64 = 100;

/// Bytes to which the entries of a small file may unpack in any case.
const MIN_BUDGET: u64 = 16 << 20;

fn malformed(at: Place, what: impl Into<String>) -> ReadError {
    ReadError::Malformed {
        format: MeshFormat::ThreeMf,
        at,
        what: what.into(),
    }
}

/// Reads all build items, in their order.
pub(super) fn read(bytes: &[u8], mut mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let mut package = Package::open(bytes)?;
    let root = package.root_model()?;
    let mut models: HashMap<String, Model> = HashMap::new();
    let first = package.model(&root, 0, &mut mesh)?;
    let mut memory = first.memory();
    let mut wanted = first.paths();
    models.insert(root.clone(), first);
    while let Some(path) = wanted.pop() {
        if let Entry::Vacant(entry) = models.entry(path) {
            let model = package.model(entry.key(), memory, &mut mesh)?;
            memory += model.memory();
            wanted.extend(model.paths());
            entry.insert(model);
        }
    }
    drop(package);
    let mut assembly = Assembly {
        models: &models,
        supports: 0,
        left: MAX_INSTANCES,
    };
    for item in models[&root].roots() {
        assembly.add(&root, item, &mut mesh)?;
    }
    if assembly.supports > 0 {
        let detail = format!(
            "{} objects were left out because the file says that they support others in a printer",
            assembly.supports
        );
        mesh.warn(WarningKind::File, detail);
    }
    mesh.finish()
}

/// Puts objects where build items and components want them.
struct Assembly<'a> {
    models: &'a HashMap<String, Model>,
    /// Objects left out because they support others.
    supports: usize,
    /// How many more references may be followed.
    left: usize,
}

impl<'a> Assembly<'a> {
    /// Adds a build item of the model at `path`: its object with everything below it. Keeps its own stack, and ends
    /// because the references that it follows are counted.
    fn add(
        &mut self,
        path: &'a str,
        item: &'a Reference,
        mesh: &mut Builder<'_>,
    ) -> Result<(), ReadError> {
        let mut open: Vec<(&str, &Reference, Matrix4<f64>, &str)> =
            vec![(path, item, Matrix4::identity(), "")];
        while let Some((path, reference, above, name)) = open.pop() {
            let at = Place::Object(reference.object);
            self.left = self.left.checked_sub(1).ok_or_else(|| {
                let what = format!(
                    "more than {MAX_INSTANCES} components, or objects that contain each other; export the mesh again"
                );
                malformed(at, what)
            })?;
            mesh.check_interrupt(self.left)?;
            let path = reference.path.as_deref().unwrap_or(path);
            let object = self.object(path, reference.object)?;
            if object.is_support {
                self.supports += 1;
                continue;
            }
            let frame = above * reference.transform;
            let name = match object.name.as_str() {
                "" => name,
                own => own,
            };
            mesh.begin_part(name.as_bytes());
            object.shape.place(&frame, at, mesh)?;
            let components = object.components.iter().rev();
            open.extend(components.map(|component| (path, component, frame, name)));
        }
        Ok(())
    }

    fn object(&self, path: &str, id: u32) -> Result<&'a Object, ReadError> {
        let found = self
            .models
            .get(path)
            .and_then(|model| model.objects.get(&id));
        found.ok_or_else(|| {
            let what = format!(
                "it is referred to, but does not exist in {}; export the mesh again",
                shown(path.as_bytes())
            );
            malformed(Place::Object(id), what)
        })
    }
}
