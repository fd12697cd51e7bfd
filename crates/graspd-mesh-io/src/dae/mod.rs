//! COLLADA (`.dae`): the geometry of a visual scene, in one XML document.
//!
//! ```text
//! scene → visual_scene → nodes → instance_geometry → geometry → mesh → triangles, polylist, polygons, ... → sources
//! ```
//!
//! What comes out are the triangles of the scene in the frame and the unit of the file: `unit` and `up_axis` are not
//! applied, as the other formats have no such thing. Transforms of nodes are applied, skins and morphs are left at rest,
//! lines and curves are no surface. A reference to another file is refused by its name, and so is a document that
//! declares entities.
//!
//! **Cost:** the document becomes a tree of the elements that matter, whose memory is limited; a geometry is read once,
//! however many nodes place it.
//!
//! | file | subject |
//! |---|---|
//! | `tree.rs` | the elements of the document, found by name or id |
//! | `geometry.rs` | a geometry, as vertices and faces |
//! | `scene.rs` | the nodes and their transforms |

mod geometry;
mod scene;
#[cfg(test)]
mod tests;
mod tree;

use graspd_core::mesh::RawMesh;

use self::scene::Scene;
use self::tree::Tree;
use super::builder::Builder;
use super::{MeshFormat, Place, ReadError};

fn malformed(at: Place, what: impl Into<String>) -> ReadError {
    ReadError::Malformed {
        format: MeshFormat::Dae,
        at,
        what: what.into(),
    }
}

/// Whether a text is an XML document with the root `COLLADA`.
pub(super) fn begins(bytes: &[u8]) -> bool {
    super::xml::root(bytes) == Some(b"COLLADA")
}

/// Reads the visual scene.
pub(super) fn read(bytes: &[u8], mut mesh: Builder<'_>) -> Result<RawMesh, ReadError> {
    let text = std::str::from_utf8(bytes).map_err(|fault| {
        let what = "the text is not UTF-8; export the mesh again, or save it as UTF-8";
        malformed(Place::Byte(fault.valid_up_to()), what)
    })?;
    let tree = Tree::parse(text, &mut mesh)?;
    Scene::new(&tree).fill(&mut mesh)?;
    mesh.finish()
}
