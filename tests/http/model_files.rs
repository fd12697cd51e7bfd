//! Model files taken apart by their specifications, with nothing of the product.

use std::collections::HashMap;

use serde_json::Value;

type Point = [f64; 3];

/// The triangles of a file, each with its number in the uploaded file if the format contains it.
pub struct Surface {
    pub triangles: Vec<[Point; 3]>,
    pub numbers: Option<Vec<u32>>,
}

impl Surface {
    /// The volume that it encloses, positive when it is wound outwards.
    pub fn volume(&self) -> f64 {
        let six_fold = |[a, b, c]: &[Point; 3]| {
            a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                - a[2] * (b[1] * c[0] - b[0] * c[1])
        };
        self.triangles.iter().map(six_fold).sum::<f64>() / 6.0
    }
}

/// Binary STL.
pub fn stl(file: &[u8]) -> Surface {
    let count = u32::from_le_bytes(file[80..84].try_into().unwrap()) as usize;
    assert_eq!(file.len(), 84 + 50 * count);
    let triangle = |record: &[u8]| {
        let numbers = floats(&record[12..48]);
        [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| numbers[3 * corner + axis]))
    };
    Surface {
        triangles: file[84..].chunks_exact(50).map(triangle).collect(),
        numbers: None,
    }
}

/// Binary PLY of double positions and triangles, each with a further number.
pub fn ply(file: &[u8]) -> Surface {
    let end = b"end_header\n";
    let start = file.windows(end.len()).position(|part| part == end);
    let start = start.expect("a header") + end.len();
    let header = std::str::from_utf8(&file[..start]).expect("text");
    assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"));
    let count = |element: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(element));
        line.expect("an element").trim().parse().expect("a count")
    };
    let properties: Vec<&str> = header
        .lines()
        .filter_map(|line| line.strip_prefix("property "))
        .collect();
    let wanted = [
        "double x",
        "double y",
        "double z",
        "list uchar uint vertex_indices",
        "uint triangle",
    ];
    assert_eq!(properties, wanted);
    let (vertices, faces) = file[start..].split_at(24 * count("element vertex"));
    assert_eq!(faces.len(), 17 * count("element face"));
    let double = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap());
    let point = |bytes: &[u8]| [0, 8, 16].map(|at| double(&bytes[at..at + 8]));
    let points: Vec<Point> = vertices.chunks_exact(24).map(point).collect();
    let (mut triangles, mut numbers) = (Vec::new(), Vec::new());
    for face in faces.chunks_exact(17) {
        assert_eq!(face[0], 3);
        let words = words(&face[1..]);
        triangles.push([0, 1, 2].map(|corner| points[words[corner] as usize]));
        numbers.push(words[3]);
    }
    Surface {
        triangles,
        numbers: Some(numbers),
    }
}

/// A GLB.
pub struct Glb {
    pub scene: Value,
    bytes: Vec<u8>,
}

impl Glb {
    pub fn new(file: &[u8]) -> Self {
        let head = words(&file[..20]);
        assert_eq!(&file[..4], b"glTF");
        assert_eq!((head[1], head[2] as usize), (2, file.len()));
        let rest = 20 + head[3] as usize;
        assert_eq!(&file[16..20], b"JSON");
        assert_eq!(&file[rest + 4..rest + 8], b"BIN\0");
        Self {
            scene: serde_json::from_slice(&file[20..rest]).expect("JSON"),
            bytes: file[rest + 8..].to_vec(),
        }
    }

    /// Its nodes by their names.
    pub fn nodes(&self) -> HashMap<&str, &Value> {
        let nodes = self.scene["nodes"].as_array().expect("nodes");
        let named = nodes
            .iter()
            .map(|node| (node["name"].as_str().expect("a name"), node));
        named.collect()
    }

    /// The surface of the node `mesh`, and the `extras` of the root.
    pub fn surface(&self) -> (Surface, &Value) {
        let nodes = self.nodes();
        let mesh = nodes["mesh"]["mesh"].as_u64().expect("a mesh") as usize;
        let primitive = &self.scene["meshes"][mesh]["primitives"][0];
        let coordinates = floats(self.accessed(&primitive["attributes"]["POSITION"], 12));
        let corners = words(self.accessed(&primitive["indices"], 4));
        let numbers = words(self.accessed(&primitive["extras"]["triangles"], 4));
        let point =
            |corner: u32| [0, 1, 2].map(|axis| coordinates[3 * corner as usize + axis as usize]);
        let surface = Surface {
            triangles: corners
                .chunks_exact(3)
                .map(|corners| [0, 1, 2].map(|n| point(corners[n])))
                .collect(),
            numbers: Some(numbers),
        };
        (surface, &nodes["graspd"]["extras"])
    }

    /// The bytes of an accessor whose elements have `size` bytes.
    fn accessed(&self, index: &Value, size: usize) -> &[u8] {
        let accessor = &self.scene["accessors"][index.as_u64().expect("an index") as usize];
        let view = accessor["bufferView"].as_u64().expect("a view") as usize;
        let start = self.scene["bufferViews"][view]["byteOffset"]
            .as_u64()
            .unwrap() as usize;
        let count = accessor["count"].as_u64().expect("a count") as usize;
        &self.bytes[start..start + size * count]
    }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    let words = bytes.chunks_exact(4);
    words
        .map(|word| u32::from_le_bytes(word.try_into().unwrap()))
        .collect()
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    let words = words(bytes);
    words
        .into_iter()
        .map(|word| f32::from_bits(word).into())
        .collect()
}
