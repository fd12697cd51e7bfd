//! Small solids made by code, and writers of every format, for tests.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use nalgebra::{Point3, Vector3};

use super::RawMesh;

/// An axis-aligned box from `low` to `high`, wound outward, 12 triangles.
pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> RawMesh {
    let vertices = (0..8)
        .map(|n| {
            let pick = |axis: usize| if n >> axis & 1 == 0 { low } else { high }[axis];
            Point3::new(pick(0), pick(1), pick(2))
        })
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    RawMesh {
        vertices,
        triangles,
    }
}

/// A cube from the origin.
pub fn cube(side: f64) -> RawMesh {
    cuboid([0.0; 3], [side; 3])
}

/// The corner of the unit cube at the origin: volume 1/6, centre of mass (1/4, 1/4, 1/4).
pub fn tetrahedron() -> RawMesh {
    RawMesh {
        vertices: vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
            Point3::new(0.0, 0.0, 1.0),
        ],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    }
}

/// A ball of meridians and parallels about the origin.
pub fn sphere(radius: f64, rings: u32, segments: u32) -> RawMesh {
    let mut vertices = vec![Point3::new(0.0, 0.0, radius)];
    for ring in 1..rings {
        let polar = PI * f64::from(ring) / f64::from(rings);
        for segment in 0..segments {
            let around = TAU * f64::from(segment) / f64::from(segments);
            vertices.push(Point3::new(
                radius * polar.sin() * around.cos(),
                radius * polar.sin() * around.sin(),
                radius * polar.cos(),
            ));
        }
    }
    vertices.push(Point3::new(0.0, 0.0, -radius));
    let last = vertices.len() as u32 - 1;
    let at = |ring: u32, segment: u32| match ring {
        0 => 0,
        _ if ring == rings => last,
        _ => 1 + (ring - 1) * segments + segment % segments,
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let (a, b) = (at(ring, segment), at(ring + 1, segment));
            let (c, d) = (at(ring + 1, segment + 1), at(ring, segment + 1));
            if ring + 1 < rings {
                triangles.push([a, b, c]);
            }
            if ring > 0 {
                triangles.push([a, c, d]);
            }
        }
    }
    RawMesh {
        vertices,
        triangles,
    }
}

/// A ring about the z axis.
pub fn torus(major: f64, minor: f64, around: u32, across: u32) -> RawMesh {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let u = TAU * f64::from(i) / f64::from(around);
            let v = TAU * f64::from(j) / f64::from(across);
            let r = major + minor * v.cos();
            vertices.push(Point3::new(r * u.cos(), r * u.sin(), minor * v.sin()));
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    RawMesh {
        vertices,
        triangles,
    }
}

/// A prism of height 1 over an L of three unit squares: volume 3, not convex.
pub fn l_shape() -> RawMesh {
    let outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)];
    let vertices = [0.0, 1.0]
        .iter()
        .flat_map(|&z| outline.map(|(x, y)| Point3::new(f64::from(x), f64::from(y), z)))
        .collect();
    let mut triangles = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.extend([[a, c, b], [a + 6, b + 6, c + 6]]);
    }
    for i in 0..6 {
        let j = (i + 1) % 6;
        triangles.extend([[i, j, j + 6], [i, j + 6, i + 6]]);
    }
    RawMesh {
        vertices,
        triangles,
    }
}

/// A cube of side 3 about the origin with a cubic cavity of side 1: volume 26.
pub fn hollow_cube() -> RawMesh {
    join(&[
        cuboid([-1.5; 3], [1.5; 3]),
        flipped(&cuboid([-0.5; 3], [0.5; 3])),
    ])
}

/// Triangles between a far point and neighbours on a row of points `step` apart.
pub fn strip(count: u32, step: f64) -> RawMesh {
    let row = (0..count).map(|n| Point3::new(f64::from(n) * step, 0.0, 0.0));
    RawMesh {
        vertices: row.chain([Point3::new(0.0, 1.0, 0.0)]).collect(),
        triangles: (1..count).map(|n| [n - 1, n, count]).collect(),
    }
}

/// Several meshes as one, none sharing a vertex.
pub fn join(parts: &[RawMesh]) -> RawMesh {
    let mut all = RawMesh {
        vertices: Vec::new(),
        triangles: Vec::new(),
    };
    for part in parts {
        let offset = all.vertices.len() as u32;
        all.vertices.extend(&part.vertices);
        all.triangles
            .extend(part.triangles.iter().map(|t| t.map(|index| index + offset)));
    }
    all
}

/// With every winding reversed.
pub fn flipped(raw: &RawMesh) -> RawMesh {
    flipped_where(raw, |_| true)
}

/// With the winding of some triangles reversed.
pub fn flipped_where(raw: &RawMesh, which: impl Fn(usize) -> bool) -> RawMesh {
    let mut raw = raw.clone();
    for (n, triangle) in raw.triangles.iter_mut().enumerate() {
        if which(n) {
            triangle.swap(0, 1);
        }
    }
    raw
}

pub fn moved(raw: &RawMesh, by: [f64; 3]) -> RawMesh {
    let mut raw = raw.clone();
    raw.vertices
        .iter_mut()
        .for_each(|v| *v += Vector3::from(by));
    raw
}

/// Without shared vertices, as STL has it.
pub fn soup(raw: &RawMesh) -> RawMesh {
    RawMesh {
        vertices: raw
            .triangles
            .iter()
            .flatten()
            .map(|&index| raw.vertices[index as usize])
            .collect(),
        triangles: (0..raw.triangles.len() as u32)
            .map(|n| [3 * n, 3 * n + 1, 3 * n + 2])
            .collect(),
    }
}

pub fn stl_binary(raw: &RawMesh, header: &str) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.resize(80, 0);
    bytes.extend((raw.triangles.len() as u32).to_le_bytes());
    for triangle in &raw.triangles {
        bytes.extend([0; 12]);
        for &index in triangle {
            for x in raw.vertices[index as usize].iter() {
                bytes.extend((*x as f32).to_le_bytes());
            }
        }
        bytes.extend([0; 2]);
    }
    bytes
}

pub fn stl_ascii(raw: &RawMesh, name: &str) -> String {
    let mut text = format!("solid {name}\n");
    for triangle in &raw.triangles {
        text.push_str("  facet normal 0 0 0\n    outer loop\n");
        for &index in triangle {
            let v = raw.vertices[index as usize];
            writeln!(text, "      vertex {:e} {:e} {:e}", v.x, v.y, v.z).unwrap();
        }
        text.push_str("    endloop\n  endfacet\n");
    }
    text + &format!("endsolid {name}\n")
}

pub fn obj(raw: &RawMesh) -> String {
    let mut text = String::from("# made by code\nmtllib /etc/passwd\no part\n");
    for v in &raw.vertices {
        writeln!(text, "v {} {} {}", v.x, v.y, v.z).unwrap();
    }
    for t in &raw.triangles {
        writeln!(text, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1).unwrap();
    }
    text
}

pub fn ply_header(raw: &RawMesh, format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made by code\nelement vertex {}\n\
         property double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        raw.vertices.len(),
        raw.triangles.len()
    )
}

pub fn ply_ascii(raw: &RawMesh) -> String {
    let mut text = ply_header(raw, "ascii");
    for v in &raw.vertices {
        writeln!(text, "{} {} {}", v.x, v.y, v.z).unwrap();
    }
    for t in &raw.triangles {
        writeln!(text, "3 {} {} {}", t[0], t[1], t[2]).unwrap();
    }
    text
}

pub fn ply_binary(raw: &RawMesh, big_endian: bool) -> Vec<u8> {
    let endian = if big_endian { "big" } else { "little" };
    let mut bytes = ply_header(raw, &format!("binary_{endian}_endian")).into_bytes();
    for x in raw.vertices.iter().flat_map(|v| v.iter()) {
        bytes.extend(if big_endian {
            x.to_be_bytes()
        } else {
            x.to_le_bytes()
        });
    }
    for triangle in &raw.triangles {
        bytes.push(3);
        for index in triangle {
            bytes.extend(if big_endian {
                index.to_be_bytes()
            } else {
                index.to_le_bytes()
            });
        }
    }
    bytes
}

pub fn off(raw: &RawMesh) -> String {
    let (vertices, triangles) = (raw.vertices.len(), raw.triangles.len());
    let mut text = format!("OFF\n# made by code\n{vertices} {triangles} 0\n");
    for v in &raw.vertices {
        writeln!(text, "{} {} {}", v.x, v.y, v.z).unwrap();
    }
    for t in &raw.triangles {
        writeln!(text, "3 {} {} {}  255 0 0", t[0], t[1], t[2]).unwrap();
    }
    text
}

/// The JSON of a glTF document whose one buffer holds what [`gltf_buffer`] gives; `uri` is its member if not
/// empty, such as `"uri": "...",`.
pub fn gltf_json(raw: &RawMesh, uri: &str) -> String {
    let (vertices, corners) = (raw.vertices.len(), 3 * raw.triangles.len());
    let (positions, indices) = (12 * vertices, 4 * corners);
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"mesh": 0, "name": "part"}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": {vertices}, "type": "VEC3"}},
            {{"bufferView": 1, "componentType": 5125, "count": {corners}, "type": "SCALAR"}}],
        "bufferViews": [
            {{"buffer": 0, "byteLength": {positions}}},
            {{"buffer": 0, "byteOffset": {positions}, "byteLength": {indices}}}],
        "buffers": [{{{uri} "byteLength": {}}}]}}"#,
        positions + indices
    )
}

/// Positions as floats, then vertex numbers.
pub fn gltf_buffer(raw: &RawMesh) -> Vec<u8> {
    let positions = raw
        .vertices
        .iter()
        .flat_map(|v| v.iter().copied().collect::<Vec<f64>>());
    let positions = positions.flat_map(|x| (x as f32).to_le_bytes());
    let indices = raw
        .triangles
        .iter()
        .flatten()
        .flat_map(|index| index.to_le_bytes());
    positions.chain(indices).collect()
}

pub fn gltf(raw: &RawMesh) -> String {
    use base64::Engine;
    let bytes = base64::engine::general_purpose::STANDARD.encode(gltf_buffer(raw));
    gltf_json(
        raw,
        &format!(r#""uri": "data:application/octet-stream;base64,{bytes}","#),
    )
}

/// A GLB of any JSON and binary chunk.
pub fn glb_of(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut bytes = b"glTF\x02\x00\x00\x00\x00\x00\x00\x00".to_vec();
    for (kind, data, filler) in [(b"JSON", json.as_bytes(), b' '), (b"BIN\0", binary, 0)] {
        let padded = data.len().next_multiple_of(4);
        bytes.extend((padded as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(data);
        bytes.resize(bytes.len() + padded - data.len(), filler);
    }
    let length = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    bytes
}

pub fn glb(raw: &RawMesh) -> Vec<u8> {
    glb_of(&gltf_json(raw, ""), &gltf_buffer(raw))
}
