//! Mesh files of every format, written apart from the library's own writers.

use std::fmt::Write;

use graspd_core::mesh::RawMesh;

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
