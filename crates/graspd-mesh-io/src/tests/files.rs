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

/// The vertices and triangles of a mesh as a 3MF model has them.
pub fn threemf_mesh(raw: &RawMesh) -> String {
    let vertices = raw
        .vertices
        .iter()
        .map(|v| format!(r#"<vertex x="{}" y="{}" z="{}"/>"#, v.x, v.y, v.z));
    let triangles = raw
        .triangles
        .iter()
        .map(|t| format!(r#"<triangle v1="{}" v2="{}" v3="{}"/>"#, t[0], t[1], t[2]));
    format!(
        "<mesh><vertices>{}</vertices><triangles>{}</triangles></mesh>",
        vertices.collect::<String>(),
        triangles.collect::<String>()
    )
}

/// A 3MF model with these objects and build items.
pub fn threemf_model(objects: &str, items: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<model unit="inch" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06" requiredextensions="p">
<metadata name="Title">made by code</metadata>
<resources>{objects}</resources><build>{items}</build></model>"#
    )
}

/// A zip archive of these entries.
pub fn archive(entries: &[(&str, &[u8])]) -> Vec<u8> {
    use std::io::Write;
    use zip::write::SimpleFileOptions;
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in entries {
        writer
            .start_file(*name, SimpleFileOptions::default())
            .unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// A 3MF file with that model.
pub fn threemf_of(model: &str) -> Vec<u8> {
    let relationships = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
        <Relationship Target="/3D/body.model" Id="r0"
            Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;
    archive(&[
        ("3D/body.model", model.as_bytes()),
        ("_rels/.rels", relationships.as_bytes()),
    ])
}

pub fn threemf(raw: &RawMesh) -> Vec<u8> {
    let object = format!(
        r#"<object id="1" name="part" type="model">{}</object>"#,
        threemf_mesh(raw)
    );
    threemf_of(&threemf_model(&object, r#"<item objectid="1"/>"#))
}

/// A COLLADA geometry `shape` with these primitives, whose inputs refer to `#vertices`.
pub fn dae_geometry(raw: &RawMesh, primitives: &str) -> String {
    let numbers: Vec<String> = raw
        .vertices
        .iter()
        .flat_map(|v| [v.x, v.y, v.z])
        .map(|x| x.to_string())
        .collect();
    format!(
        r##"<geometry id="shape"><mesh><source id="positions"><float_array id="numbers" count="{}">{}</float_array>
        <technique_common><accessor source="#numbers" count="{}" stride="3"><param name="X" type="float"/></accessor>
        </technique_common></source><vertices id="vertices"><input semantic="POSITION" source="#positions"/></vertices>
        {primitives}</mesh></geometry>"##,
        numbers.len(),
        numbers.join(" "),
        raw.vertices.len()
    )
}

/// The triangles of a mesh as COLLADA has them.
pub fn dae_triangles(raw: &RawMesh) -> String {
    let corners: Vec<String> = raw.triangles.iter().flatten().map(u32::to_string).collect();
    format!(
        r##"<triangles count="{}"><input semantic="VERTEX" source="#vertices" offset="0"/><p>{}</p></triangles>"##,
        raw.triangles.len(),
        corners.join(" ")
    )
}

/// A COLLADA document with these geometries and, unless it is empty, a scene of these nodes.
pub fn dae_of(geometries: &str, nodes: &str) -> String {
    let scene = match nodes {
        "" => String::new(),
        nodes => format!(
            r##"<library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>
            <scene><instance_visual_scene url="#scene"/></scene>"##
        ),
    };
    format!(
        r#"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit name="inch" meter="0.0254"/>
<up_axis>Y_UP</up_axis></asset><library_effects><effect id="paint"><p>not a number</p></effect></library_effects>
<library_geometries>{geometries}</library_geometries>{scene}</COLLADA>
"#
    )
}

pub fn dae(raw: &RawMesh) -> String {
    let nodes = r##"<node id="part"><instance_geometry url="#shape"/></node>"##;
    dae_of(&dae_geometry(raw, &dae_triangles(raw)), nodes)
}
