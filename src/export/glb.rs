//! Writes GLB, the binary container of glTF 2.0: nodes, meshes and materials as JSON, their numbers as
//! bytes. A crate such as `gltf` reads this format; for writing, the few members that are needed here
//! are shorter as JSON than as its types.

use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

/// Component types (glTF 2.0, 3.6.2.2).
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
/// Targets of buffer views (glTF 2.0, 5.11.5).
const VERTICES: u32 = 34962;
const CORNERS: u32 = 34963;
/// The magic number and the chunk types of the container (glTF 2.0, 4.4).
const MAGIC: &[u8; 4] = b"glTF";
const JSON_CHUNK: &[u8; 4] = b"JSON";
const BINARY_CHUNK: &[u8; 4] = b"BIN\0";

/// A scene under construction. Every method returns the index of what it added.
#[derive(Debug, Default)]
pub(super) struct Glb {
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    bytes: Vec<u8>,
}

impl Glb {
    /// Adds positions, relative to `origin`, in single precision.
    pub fn positions(&mut self, points: &[Point3<f64>], origin: &Vector3<f64>) -> usize {
        let single = |point: &Point3<f64>| [0, 1, 2].map(|n| (point[n] - origin[n]) as f32);
        let points: Vec<[f32; 3]> = points.iter().map(single).collect();
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for point in &points {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let view = self.view(
            points.iter().flatten().map(|x| x.to_le_bytes()),
            VERTICES.into(),
        );
        self.accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": points.len(), "type": "VEC3",
            "min": low, "max": high,
        }))
    }

    /// Adds the corners of triangles.
    pub fn corners(&mut self, triangles: &[[u32; 3]]) -> usize {
        let numbers = triangles.iter().flatten();
        let view = self.view(numbers.map(|x| x.to_le_bytes()), CORNERS.into());
        self.accessor(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": 3 * triangles.len(),
            "type": "SCALAR",
        }))
    }

    /// Adds numbers that mean something to this program alone.
    pub fn numbers(&mut self, numbers: &[u32]) -> usize {
        let view = self.view(numbers.iter().map(|x| x.to_le_bytes()), None);
        self.accessor(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": numbers.len(),
            "type": "SCALAR",
        }))
    }

    /// Adds a matt material visible from both sides, in linear red, green, blue and opacity.
    pub fn material(&mut self, name: &str, color: [f64; 4]) -> usize {
        let mut material = json!({
            "name": name, "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": 0.8,
            },
        });
        if color[3] < 1.0 {
            material["alphaMode"] = json!("BLEND");
        }
        push(&mut self.materials, material)
    }

    /// Adds a mesh of one primitive.
    pub fn mesh(&mut self, name: &str, primitive: Value) -> usize {
        push(
            &mut self.meshes,
            json!({"name": name, "primitives": [primitive]}),
        )
    }

    /// Adds a node.
    pub fn node(&mut self, node: Value) -> usize {
        push(&mut self.nodes, node)
    }

    /// Returns the file, with the scene below the node `root`.
    pub fn finish(self, root: usize) -> Result<Vec<u8>, serde_json::Error> {
        let mut scene = json!({
            "asset": {"version": "2.0", "generator": concat!("graspd ", env!("CARGO_PKG_VERSION"))},
            "scene": 0,
            "scenes": [{"nodes": [root]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": self.bytes.len()}],
        });
        if !self.materials.is_empty() {
            scene["materials"] = self.materials.into();
        }
        let mut text = serde_json::to_vec(&scene)?;
        text.resize(text.len().next_multiple_of(4), b' ');
        // Chunks are padded to four bytes; the binary one consists of words of four bytes already.
        let bytes = self.bytes;
        let total = 12 + 8 + text.len() + 8 + bytes.len();
        let mut file = Vec::with_capacity(total);
        file.extend(MAGIC);
        file.extend(2_u32.to_le_bytes());
        file.extend((total as u32).to_le_bytes());
        for (kind, chunk) in [(JSON_CHUNK, &text), (BINARY_CHUNK, &bytes)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        Ok(file)
    }

    fn view(&mut self, words: impl Iterator<Item = [u8; 4]>, target: Option<u32>) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(words.flatten());
        let mut view = json!({
            "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start,
        });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        push(&mut self.views, view)
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        push(&mut self.accessors, accessor)
    }
}

fn push(list: &mut Vec<Value>, value: Value) -> usize {
    list.push(value);
    list.len() - 1
}
