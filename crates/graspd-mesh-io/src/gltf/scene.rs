//! The triangles of a scene: meshes where their nodes have them.
//!
//! Nodes form trees. Each has a transform into the frame of its parent, and may have a mesh; the transform of a mesh
//! into the frame of the scene is the product of those on the way to the root:
//!
//! ```text
//! open = the roots of the scene, with the identity
//! while a node is open:
//!     frame = frame of its parent · its own transform
//!     add its mesh, transformed by frame
//!     open its children, in their order
//! ```
//!
//! **Why it ends:** a node that is reached twice is an error, so cycles and shared branches, which could make a small
//! file endless or huge, are not followed. The walk keeps its own stack: a chain of a hundred thousand nodes is no
//! reason to overflow that of the thread.

use nalgebra::{Affine3, Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3, Vector4};

use super::accessor::Accessors;
use super::document::{Document, Node, Primitive};
use super::{Source, item};
use crate::ReadError;
use crate::builder::Builder;

/// The mode of a primitive whose corners come in threes.
const TRIANGLES: u32 = 4;
/// The mode of a primitive in which each corner makes a triangle with the two before it.
const STRIP: u32 = 5;
/// The mode of a primitive in which each corner makes a triangle with the one before it and the first.
const FAN: u32 = 6;

/// A document whose scene is read.
pub(super) struct Scene<'a> {
    pub(super) document: &'a Document<'a>,
    pub(super) accessors: &'a Accessors<'a>,
    pub(super) source: Source,
}

impl Scene<'_> {
    /// Adds the triangles of the default scene, or else of the first one, or else of all nodes, or where there are
    /// no nodes of all meshes.
    pub(super) fn fill(&self, mesh: &mut Builder<'_>) -> Result<(), ReadError> {
        let nodes = &self.document.nodes.0;
        if nodes.is_empty() {
            let meshes = 0..self.document.meshes.0.len() as u32;
            let identity = Matrix4::identity();
            return meshes
                .into_iter()
                .try_for_each(|index| self.add_mesh(mesh, index, [None; 2], &identity));
        }
        let mut reached = vec![false; nodes.len()];
        // A stack, so what comes first is put on it last.
        let roots = self.roots()?.into_iter().rev();
        let mut open: Vec<Open<'_>> = roots.map(Open::root).collect();
        while let Some(Open { index, above, name }) = open.pop() {
            let wrong = |what: &str| self.source.malformed(item("nodes", index), what);
            let node = nodes.get(index as usize);
            let node = node.ok_or_else(|| wrong(MISSING))?;
            if std::mem::replace(&mut reached[index as usize], true) {
                return Err(wrong(
                    "it is reached twice, but nodes must form trees; export the mesh again",
                ));
            }
            let frame = above * transform(node).map_err(|what| wrong(&what))?;
            let own = node.name.as_deref().filter(|own| !own.is_empty());
            if let Some(index) = node.mesh {
                self.add_mesh(mesh, index, [own, name], &frame)?;
            }
            let name = own.or(name);
            open.extend(node.children.iter().rev().map(|&index| Open {
                index,
                above: frame,
                name,
            }));
        }
        Ok(())
    }

    /// The nodes at the top of the scene.
    fn roots(&self) -> Result<Vec<u32>, ReadError> {
        let scenes = &self.document.scenes.0;
        let index = self.document.scene.unwrap_or_default();
        match scenes.get(index) {
            Some(scene) => Ok(scene.nodes.clone()),
            None if self.document.scene.is_some() => {
                let at = item("scenes", index as u32);
                Err(self.source.malformed(at, MISSING))
            }
            None => {
                let nodes = &self.document.nodes.0;
                let mut is_child = vec![false; nodes.len()];
                for &child in nodes.iter().flat_map(|node| &node.children) {
                    if let Some(child) = is_child.get_mut(child as usize) {
                        *child = true;
                    }
                }
                let roots = (0..nodes.len()).filter(|&index| !is_child[index]);
                Ok(roots.map(|index| index as u32).collect())
            }
        }
    }

    /// Adds a mesh as a part with the name of its node, or else its own, or else that of a node above.
    fn add_mesh(
        &self,
        mesh: &mut Builder<'_>,
        index: u32,
        [node, above]: [Option<&str>; 2],
        frame: &Matrix4<f64>,
    ) -> Result<(), ReadError> {
        let found = self.document.meshes.0.get(index as usize);
        let missing = || self.source.malformed(item("meshes", index), MISSING);
        let found = found.ok_or_else(missing)?;
        let own = found.name.as_deref().filter(|own| !own.is_empty());
        let name = node.or(own).or(above).unwrap_or_default();
        mesh.begin_part(name.as_bytes());
        let mut primitives = found.primitives.0.iter();
        primitives.try_for_each(|primitive| self.add_primitive(mesh, index, primitive, frame))
    }

    /// Adds a primitive of the mesh with index `of`.
    fn add_primitive(
        &self,
        mesh: &mut Builder<'_>,
        of: u32,
        primitive: &Primitive,
        frame: &Matrix4<f64>,
    ) -> Result<(), ReadError> {
        let Self {
            accessors, source, ..
        } = self;
        let wrong = |what: String| source.malformed(item("meshes", of), what);
        match primitive.mode {
            // Points and lines are no surface.
            0..TRIANGLES => return Ok(()),
            TRIANGLES | STRIP | FAN => {}
            mode => {
                return Err(wrong(format!(
                    "{mode} is not a primitive mode; export the mesh again"
                )));
            }
        }
        let Some(positions) = primitive.attributes.position else {
            return Ok(());
        };
        let frame = Affine3::from_matrix_unchecked(*frame);
        let first = mesh.vertices() as u32;
        accessors.positions(positions, |position| {
            mesh.note_single(position);
            let at = frame.transform_point(&position.into());
            mesh.vertex([at.x, at.y, at.z], item("accessors", positions))
                .map(|_| ())
        })?;
        let count = accessors.count(positions)?;
        // A transform that mirrors turns the winding over.
        let mirrored = frame.matrix().fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        let mut corners = Corners {
            mode: primitive.mode,
            mirrored,
            first: None,
            last: [0; 2],
            seen: 0,
        };
        let mut add = |index: u32| match corners.next(index) {
            Some(triangle) => mesh.triangle(triangle.map(|corner| first + corner)),
            None => Ok(()),
        };
        let total = match primitive.indices {
            Some(indices) => {
                let numbers = accessors.indices(indices)?;
                let total = numbers.len() as u64;
                for number in numbers {
                    if u64::from(number) >= count {
                        let what = format!(
                            "it names vertex {number} (counted from 0), but there are {count}; export the mesh again"
                        );
                        return Err(source.malformed(item("accessors", indices), what));
                    }
                    add(number)?;
                }
                total
            }
            None => {
                // So many positions are in the mesh by now, so their number fits.
                (0..count as u32).try_for_each(add)?;
                count
            }
        };
        if primitive.mode == TRIANGLES && !total.is_multiple_of(3) {
            return Err(wrong(format!(
                "{total} corners do not make whole triangles; export the mesh again"
            )));
        }
        Ok(())
    }
}

/// What it says of a place that is referred to without being there.
const MISSING: &str = "it is referred to, but does not exist; export the mesh again";

/// A node that the walk has yet to visit.
struct Open<'a> {
    index: u32,
    /// The frame of its parent.
    above: Matrix4<f64>,
    /// The name of the closest node above that has one.
    name: Option<&'a str>,
}

impl Open<'_> {
    fn root(index: u32) -> Self {
        Self {
            index,
            above: Matrix4::identity(),
            name: None,
        }
    }
}

/// From the frame of a node to that of its parent.
fn transform(node: &Node<'_>) -> Result<Matrix4<f64>, String> {
    if let Some(matrix) = &node.matrix {
        let matrix = Matrix4::from_column_slice(&matrix[..]);
        let is_affine = matrix.row(3) == Vector4::new(0.0, 0.0, 0.0, 1.0).transpose();
        return match is_affine {
            true => Ok(matrix),
            false => Err("its matrix is not an affine map: the last row must be 0, 0, 0, 1; export the mesh again".to_owned()),
        };
    }
    let translation = node.translation.as_deref().copied().unwrap_or_default();
    let scale = node.scale.as_deref().copied().unwrap_or([1.0; 3]);
    let [x, y, z, w] = node
        .rotation
        .as_deref()
        .copied()
        .unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-12)
        .ok_or("its rotation is not a unit quaternion; export the mesh again")?;
    let turned =
        Translation3::from(Vector3::from(translation)).to_homogeneous() * rotation.to_homogeneous();
    Ok(turned * Matrix4::new_nonuniform_scaling(&Vector3::from(scale)))
}

/// Makes triangles of the corners of a primitive, one after the other.
struct Corners {
    mode: u32,
    mirrored: bool,
    first: Option<u32>,
    last: [u32; 2],
    seen: u64,
}

impl Corners {
    /// Takes a corner, and returns the triangle that it completes.
    fn next(&mut self, corner: u32) -> Option<[u32; 3]> {
        let [before, last] = self.last;
        let first = *self.first.get_or_insert(corner);
        self.last = [last, corner];
        self.seen += 1;
        let triangle = match self.mode {
            TRIANGLES => self
                .seen
                .is_multiple_of(3)
                .then_some([before, last, corner]),
            STRIP if self.seen < 3 => None,
            // Every other triangle of a strip runs the other way round.
            STRIP if self.seen.is_multiple_of(2) => Some([last, before, corner]),
            STRIP => Some([before, last, corner]),
            _ => (self.seen >= 3).then_some([first, last, corner]),
        };
        triangle.map(|[a, b, c]| if self.mirrored { [a, c, b] } else { [a, b, c] })
    }
}
