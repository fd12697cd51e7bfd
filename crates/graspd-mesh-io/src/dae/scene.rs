//! From the nodes of a scene to the triangles, as the glTF reader does it: each node has transforms, in their order, and
//! may have geometries and other nodes.
//!
//! **Why it ends:** a node may be placed many times, so that even nodes which contain each other would never end; the
//! nodes and geometries that are visited are counted, and more than [`MAX_INSTANCES`] are refused. The walk keeps its own
//! stack.

use std::collections::HashMap;
use std::rc::Rc;

use nalgebra::{Matrix4, Unit, Vector3};

use super::geometry;
use super::malformed;
use super::tree::{Element, Tree};
use crate::ReadError;
use crate::builder::Builder;
use crate::instance::{MAX_INSTANCES, Shape};

/// A document whose scene is read.
pub(super) struct Scene<'t> {
    tree: &'t Tree<'t>,
    /// The geometries read so far, by their elements.
    shapes: HashMap<u32, Shape>,
    /// The bytes of memory that they take.
    memory: usize,
    /// How many more nodes and geometries may be visited.
    left: usize,
}

/// A node that the walk has yet to visit.
struct Open<'t> {
    node: Element<'t>,
    above: Matrix4<f64>,
    /// The name of the closest node above that has one.
    name: Rc<str>,
}

impl<'t> Scene<'t> {
    pub(super) fn new(tree: &'t Tree<'t>) -> Self {
        Self {
            tree,
            shapes: HashMap::new(),
            memory: 0,
            left: MAX_INSTANCES,
        }
    }

    /// Adds the triangles of the scene, or else of the first visual scene, or else of all geometries.
    pub(super) fn fill(&mut self, mesh: &mut Builder<'_>) -> Result<(), ReadError> {
        let Some(root) = self.tree.root() else {
            return Ok(());
        };
        let instance = root
            .child("scene")
            .and_then(|scene| scene.child("instance_visual_scene"));
        let first = || {
            let scenes = root.child("library_visual_scenes")?;
            scenes.child("visual_scene")
        };
        let scene = match instance {
            Some(instance) => Some(instance.target("url", "visual_scene")?),
            None => first(),
        };
        let Some(scene) = scene else {
            let libraries = root
                .children()
                .filter(|child| child.name() == "library_geometries");
            let mut geometries = libraries.flat_map(|library| library.children());
            let identity = Matrix4::identity();
            return geometries.try_for_each(|geometry| self.place(geometry, &identity, "", mesh));
        };
        let mut open: Vec<Open<'t>> = Vec::new();
        let roots = |node| Open {
            node,
            above: Matrix4::identity(),
            name: Rc::from(""),
        };
        push(&mut open, scene, roots);
        while let Some(Open { node, above, name }) = open.pop() {
            self.visit(node, mesh)?;
            let own = label(node);
            let frame = above * transform(node)?;
            let name = if own.is_empty() { name } else { Rc::from(own) };
            for child in node.children() {
                match child.name() {
                    "instance_geometry" => {
                        let geometry = child.target("url", "geometry")?;
                        self.place(geometry, &frame, &name, mesh)?;
                    }
                    "instance_controller" => {
                        let (geometry, bind) = skinned(child)?;
                        self.place(geometry, &(frame * bind), &name, mesh)?;
                    }
                    _ => {}
                }
            }
            let below = |node| Open {
                node,
                above: frame,
                name: name.clone(),
            };
            push(&mut open, node, below);
            for instance in node
                .children()
                .filter(|child| child.name() == "instance_node")
            {
                open.push(below(instance.target("url", "node")?));
            }
        }
        Ok(())
    }

    /// Counts a visit.
    fn visit(&mut self, element: Element<'t>, mesh: &mut Builder<'_>) -> Result<(), ReadError> {
        self.left = self.left.checked_sub(1).ok_or_else(|| {
            let what = format!(
                "the scene has more than {MAX_INSTANCES} nodes, or nodes that contain each other; export the mesh again"
            );
            malformed(element.place(), what)
        })?;
        mesh.check_interrupt(self.left)
    }

    /// Adds a geometry as a part with that name, or its own where it is empty.
    fn place(
        &mut self,
        geometry: Element<'t>,
        frame: &Matrix4<f64>,
        name: &str,
        mesh: &mut Builder<'_>,
    ) -> Result<(), ReadError> {
        self.visit(geometry, mesh)?;
        if !self.shapes.contains_key(&geometry.index) {
            let shape = geometry::read(geometry)?;
            self.memory += shape.memory();
            mesh.check_memory(0, self.memory)?;
            self.shapes.insert(geometry.index, shape);
        }
        let own = label(geometry);
        let name = if name.is_empty() { &own } else { name };
        mesh.begin_part(name.as_bytes());
        match self.shapes.get(&geometry.index) {
            Some(shape) => shape.place(frame, geometry.place(), mesh),
            None => Ok(()),
        }
    }
}

/// Puts the nodes below an element on the stack, the first one on top.
fn push<'t>(open: &mut Vec<Open<'t>>, parent: Element<'t>, make: impl Fn(Element<'t>) -> Open<'t>) {
    let begin = open.len();
    open.extend(
        parent
            .children()
            .filter(|child| child.name() == "node")
            .map(make),
    );
    open[begin..].reverse();
}

/// What people call an element: its name, or else its id.
fn label(element: Element<'_>) -> String {
    let name = element.attribute("name").filter(|name| !name.is_empty());
    let label = name.or_else(|| element.attribute("id")).unwrap_or_default();
    label.chars().take(256).collect()
}

/// The geometry of a skin or a morph, and the transform that binds it.
fn skinned<'t>(instance: Element<'t>) -> Result<(Element<'t>, Matrix4<f64>), ReadError> {
    let mut controller = instance.target("url", "controller")?;
    let mut bind = Matrix4::identity();
    // A skin may bind a morph, which bends a geometry; deeper chains make no sense.
    for _ in 0..3 {
        let skin = controller.child("skin");
        let Some(source) = skin.or_else(|| controller.child("morph")) else {
            break;
        };
        if let Some(matrix) = source.child("bind_shape_matrix") {
            bind *= matrix_of(matrix)?;
        }
        if let Ok(geometry) = source.target("source", "geometry") {
            return Ok((geometry, bind));
        }
        controller = source.target("source", "controller")?;
    }
    Err(malformed(
        controller.place(),
        "the controller binds no geometry; export the mesh again",
    ))
}

/// From the frame of a node to that of its parent: the product of its transforms.
fn transform(node: Element<'_>) -> Result<Matrix4<f64>, ReadError> {
    let mut frame = Matrix4::identity();
    for child in node.children() {
        frame *= match child.name() {
            "matrix" => matrix_of(child)?,
            "translate" => Matrix4::new_translation(&Vector3::from(numbers::<3>(child)?)),
            "scale" => Matrix4::new_nonuniform_scaling(&Vector3::from(numbers::<3>(child)?)),
            "rotate" => {
                let [x, y, z, degrees] = numbers(child)?;
                match Unit::try_new(Vector3::new(x, y, z), 1e-12) {
                    Some(axis) => Matrix4::from_axis_angle(&axis, degrees.to_radians()),
                    None if degrees == 0.0 => Matrix4::identity(),
                    None => {
                        return Err(malformed(
                            child.place(),
                            "a rotation has no axis; export the mesh again",
                        ));
                    }
                }
            }
            "lookat" | "skew" => {
                let what = format!(
                    "a node has the transform <{}>, which cannot be read; export the mesh with matrices",
                    child.name()
                );
                return Err(malformed(child.place(), what));
            }
            _ => continue,
        };
    }
    Ok(frame)
}

/// A matrix, row by row.
fn matrix_of(element: Element<'_>) -> Result<Matrix4<f64>, ReadError> {
    let matrix = Matrix4::from_row_slice(&numbers::<16>(element)?);
    match matrix.row(3).iter().copied().eq([0.0, 0.0, 0.0, 1.0]) {
        true => Ok(matrix),
        false => {
            let what = "a matrix is not an affine map: the last row must be 0, 0, 0, 1; export the mesh again";
            Err(malformed(element.place(), what))
        }
    }
}

/// Exactly so many numbers.
fn numbers<const N: usize>(element: Element<'_>) -> Result<[f64; N], ReadError> {
    let mut found = [0.0; N];
    let mut values = element.values::<f64>();
    for number in &mut found {
        let missing = || {
            let what = format!(
                "<{}> has fewer than {N} numbers; export the mesh again",
                element.name()
            );
            malformed(element.place(), what)
        };
        *number = values.next().ok_or_else(missing)??;
    }
    Ok(found)
}
