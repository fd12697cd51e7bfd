//! The triangles of a scene: meshes where their nodes have them.

use nalgebra::{Affine3, Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3, Vector4};

use super::accessor::Accessors;
use super::document::{Document, Node, Primitive};
use super::{Source, item};
use crate::ReadError;
use crate::builder::Builder;

/// Adds all triangles of the default scene, or else the first one, or else of all nodes, or where there are none
/// of all meshes.
pub(super) fn fill(
    mesh: &mut Builder<'_>,
    document: &Document<'_>,
    accessors: &Accessors<'_>,
    source: Source,
) -> Result<(), ReadError> {
    let nodes = &document.nodes.0;
    if nodes.is_empty() {
        return (0..document.meshes.0.len() as u32).try_for_each(|index| {
            add_mesh(
                mesh,
                document,
                accessors,
                source,
                index,
                &Matrix4::identity(),
            )
        });
    }
    let mut reached = vec![false; nodes.len()];
    let mut open: Vec<(u32, Matrix4<f64>)> = Vec::new();
    let roots = roots(document, source)?;
    open.extend(
        roots
            .into_iter()
            .rev()
            .map(|root| (root, Matrix4::identity())),
    );
    while let Some((index, above)) = open.pop() {
        let wrong = |what: &str| source.malformed(item("nodes", index), what);
        let node = nodes.get(index as usize);
        let node =
            node.ok_or_else(|| wrong("it is named, but does not exist; export the mesh again"))?;
        if std::mem::replace(&mut reached[index as usize], true) {
            return Err(wrong(
                "it is reached twice, but nodes must form trees; export the mesh again",
            ));
        }
        let here = above * local(node).map_err(|what| wrong(&what))?;
        if let Some(index) = node.mesh {
            add_mesh(mesh, document, accessors, source, index, &here)?;
        }
        open.extend(node.children.iter().rev().map(|&child| (child, here)));
    }
    Ok(())
}

fn roots(document: &Document<'_>, source: Source) -> Result<Vec<u32>, ReadError> {
    let scenes = &document.scenes.0;
    let index = document.scene.unwrap_or_default();
    match scenes.get(index) {
        Some(scene) => Ok(scene.nodes.clone()),
        None if document.scene.is_some() => Err(source.malformed(
            item("scenes", index as u32),
            "it is named, but does not exist; export the mesh again",
        )),
        None => {
            let nodes = &document.nodes.0;
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

/// From the frame of a node to that of its parent.
fn local(node: &Node) -> Result<Matrix4<f64>, String> {
    if let Some(matrix) = &node.matrix {
        let matrix = Matrix4::from_column_slice(&matrix[..]);
        let is_affine = matrix.row(3) == Vector4::new(0.0, 0.0, 0.0, 1.0).transpose();
        return match is_affine {
            true => Ok(matrix),
            false => Err("its matrix is no affine map: the last row must be 0, 0, 0, 1".to_owned()),
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
        .ok_or("its rotation is no unit quaternion; export the mesh again")?;
    let turned =
        Translation3::from(Vector3::from(translation)).to_homogeneous() * rotation.to_homogeneous();
    Ok(turned * Matrix4::new_nonuniform_scaling(&Vector3::from(scale)))
}

fn add_mesh(
    mesh: &mut Builder<'_>,
    document: &Document<'_>,
    accessors: &Accessors<'_>,
    source: Source,
    index: u32,
    frame: &Matrix4<f64>,
) -> Result<(), ReadError> {
    let found = document.meshes.0.get(index as usize);
    let found = found.ok_or_else(|| {
        source.malformed(
            item("meshes", index),
            "it is named, but does not exist; export the mesh again",
        )
    })?;
    let primitives = found.primitives.0.iter();
    primitives
        .into_iter()
        .try_for_each(|primitive| add_primitive(mesh, accessors, source, index, primitive, frame))
}

fn add_primitive(
    mesh: &mut Builder<'_>,
    accessors: &Accessors<'_>,
    source: Source,
    of: u32,
    primitive: &Primitive,
    frame: &Matrix4<f64>,
) -> Result<(), ReadError> {
    let wrong = |what: String| source.malformed(item("meshes", of), what);
    let strip = match primitive.mode {
        // Points and lines are no surface.
        0..=3 => return Ok(()),
        4 => false,
        5 | 6 => true,
        mode => {
            return Err(wrong(format!(
                "{mode} is no primitive mode; export the mesh again"
            )));
        }
    };
    let Some(positions) = primitive.attributes.position else {
        return Ok(());
    };
    let frame = Affine3::from_matrix_unchecked(*frame);
    let first = mesh.vertices() as u32;
    accessors.positions(positions, |position| {
        let at = frame.transform_point(&position.into());
        mesh.vertex([at.x, at.y, at.z], item("accessors", positions))
            .map(|_| ())
    })?;
    let count = accessors.count(positions)?;
    // A mirror turns the winding over.
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
                        "vertex {number} (counted from 0) is named, but there are {count}; export the mesh again"
                    );
                    return Err(source.malformed(item("accessors", indices), what));
                }
                add(number)?;
            }
            total
        }
        None => {
            // As many positions were taken into the mesh, so they can be counted.
            (0..count as u32).try_for_each(add)?;
            count
        }
    };
    if !strip && !total.is_multiple_of(3) {
        return Err(wrong(format!(
            "{total} corners are no whole triangles; export the mesh again"
        )));
    }
    Ok(())
}

/// Makes triangles of corners as they come.
struct Corners {
    mode: u32,
    mirrored: bool,
    first: Option<u32>,
    last: [u32; 2],
    seen: u64,
}

impl Corners {
    fn next(&mut self, corner: u32) -> Option<[u32; 3]> {
        let [before, last] = self.last;
        let first = *self.first.get_or_insert(corner);
        self.last = [last, corner];
        self.seen += 1;
        let triangle = match self.mode {
            4 => self
                .seen
                .is_multiple_of(3)
                .then_some([before, last, corner]),
            5 if self.seen < 3 => None,
            5 if self.seen.is_multiple_of(2) => Some([last, before, corner]),
            5 => Some([before, last, corner]),
            _ => (self.seen >= 3).then_some([first, last, corner]),
        };
        triangle.map(|[a, b, c]| if self.mirrored { [a, c, b] } else { [a, b, c] })
    }
}
