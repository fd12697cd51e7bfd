//! Scenes of all shapes, and documents that promise what they do not have.

use nalgebra::Point3;

use graspd_core::mesh::RawMesh;

use crate::tests::files::{glb_of, gltf_buffer, gltf_json};
use crate::{Limits, MeshFormat, Place, ReadError, read};
use graspd_core::mesh::solids::{cube, soup, tetrahedron};

const LIMITS: Limits = Limits {
    triangles: 1000,
    vertices: 1000,
    ..Limits::NONE
};

fn good(json: &str, binary: &[u8]) -> RawMesh {
    read(&glb_of(json, binary), None, &LIMITS).unwrap().1
}

fn wrong(json: &str, binary: &[u8]) -> (Place, String) {
    match read(&glb_of(json, binary), None, &LIMITS).unwrap_err() {
        ReadError::Malformed {
            format: MeshFormat::Glb,
            at,
            what,
        } => (at, what),
        other => panic!("{other:?}"),
    }
}

/// The tetrahedron with something in its document replaced.
fn replaced(from: &str, to: &str) -> String {
    let json = gltf_json(&tetrahedron(), "");
    assert!(json.contains(from), "{json}");
    json.replace(from, to)
}

fn buffer() -> Vec<u8> {
    gltf_buffer(&tetrahedron())
}

const NODES: &str = r#""nodes": [{"mesh": 0, "name": "part"}]"#;

fn places(raw: &RawMesh) -> Vec<[f64; 3]> {
    raw.vertices.iter().map(|v| [v.x, v.y, v.z]).collect()
}

#[test]
fn nodes_turn_scale_and_move_what_is_below_them() {
    // A quarter turn about z, after doubling, before moving; and the same as a matrix.
    let half = 0.5_f64.sqrt();
    let factors = format!(
        r#""nodes": [{{"children": [1], "translation": [5, 0, 0]}},
        {{"mesh": 0, "rotation": [0, 0, {half}, {half}], "scale": [2, 2, 2]}}]"#
    );
    let matrix = r#""nodes": [{"children": [1], "translation": [5, 0, 0]},
        {"mesh": 0, "matrix": [0,2,0,0, -2,0,0,0, 0,0,2,0, 0,0,0,1]}]"#;
    for nodes in [factors.as_str(), matrix] {
        let raw = good(&replaced(NODES, nodes), &buffer());
        for (found, own) in raw.vertices.iter().zip(&tetrahedron().vertices) {
            let wanted = Point3::new(5.0 - 2.0 * own.y, 2.0 * own.x, 2.0 * own.z);
            assert!((found - wanted).norm() < 1e-14, "{found} {wanted}");
        }
        assert_eq!(raw.triangles, tetrahedron().triangles);
    }
}

#[test]
fn a_mirror_turns_the_winding_over() {
    let raw = good(
        &replaced(NODES, r#""nodes": [{"mesh": 0, "scale": [-1, 1, 1]}]"#),
        &buffer(),
    );
    let wanted = tetrahedron()
        .triangles
        .iter()
        .map(|&[a, b, c]| [a, c, b])
        .collect::<Vec<_>>();
    assert_eq!(raw.triangles, wanted);
}

#[test]
fn the_scene_decides_which_nodes_count_and_instances_count_each() {
    let nodes = r#""nodes": [{"mesh": 0}, {"mesh": 0, "translation": [3, 0, 0]}, {"mesh": 0}, {"camera": 0}]"#;
    let json = replaced(NODES, nodes);
    assert_eq!(good(&json, &buffer()).triangles.len(), 4);
    let two = json.replace(r#"[{"nodes": [0]}]"#, r#"[{}, {"nodes": [1, 0, 3]}]"#);
    let two = two.replace(r#""scene": 0"#, r#""scene": 1"#);
    let raw = good(&two, &buffer());
    assert_eq!(
        (raw.triangles.len(), places(&raw)[0], places(&raw)[4]),
        (8, [3.0, 0.0, 0.0], [0.0; 3])
    );
    let all = json
        .replace(r#""scenes": [{"nodes": [0]}],"#, "")
        .replace(r#""scene": 0,"#, "");
    assert_eq!(good(&all, &buffer()).triangles.len(), 12);
    let none = replaced(&format!("{NODES},"), "");
    assert_eq!(good(&none, &buffer()).triangles.len(), 4);
    let few = Limits {
        triangles: 11,
        ..LIMITS
    };
    let error = read(&glb_of(&all, &buffer()), None, &few).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { limit: 11, .. }));
}

#[test]
fn strips_and_fans_are_triangles_too() {
    // Four corners as numbers of one byte each, padded.
    let count = |mode: u32, count: usize| {
        replaced(
            r#""indices": 1}"#,
            &format!(r#""indices": 1, "mode": {mode}}}"#),
        )
        .replace(
            r#""componentType": 5125, "count": 12"#,
            &format!(r#""componentType": 5125, "count": {count}"#),
        )
    };
    let mut bytes = buffer();
    for (at, index) in [3_u32, 1, 0, 2, 1].into_iter().enumerate() {
        bytes[48 + 4 * at..52 + 4 * at].copy_from_slice(&index.to_le_bytes());
    }
    assert_eq!(
        good(&count(5, 5), &bytes).triangles,
        [[3, 1, 0], [0, 1, 2], [0, 2, 1]]
    );
    assert_eq!(
        good(&count(6, 5), &bytes).triangles,
        [[3, 1, 0], [3, 0, 2], [3, 2, 1]]
    );
    let error = read(&glb_of(&count(1, 4), &bytes), None, &LIMITS).unwrap_err();
    assert_eq!(error, ReadError::NoTriangles);
    let unindexed = replaced(r#", "indices": 1}"#, ", \"mode\": 6}");
    assert_eq!(
        good(&unindexed, &buffer()).triangles,
        [[0, 1, 2], [0, 2, 3]]
    );
}

#[test]
fn numbers_may_be_interleaved_quantised_and_replaced() {
    let raw = cube(1.0);
    // Each position as three signed bytes and one of padding, then the vertex numbers as bytes.
    let mut bytes: Vec<u8> = Vec::new();
    for v in &raw.vertices {
        bytes.extend([v.x, v.y, v.z].map(|x| (x * 127.0) as i8 as u8));
        bytes.push(99);
    }
    bytes.extend(raw.triangles.iter().flatten().map(|&index| index as u8));
    let json = |normalized: bool, extra: &str| {
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "extensionsRequired": ["KHR_mesh_quantization"],
            "nodes": [{{"mesh": 0}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
            "accessors": [
                {{"bufferView": 0, "componentType": 5120, "normalized": {normalized}, "count": 8, "type": "VEC3"{extra}}},
                {{"bufferView": 1, "componentType": 5121, "count": 36, "type": "SCALAR"}}],
            "bufferViews": [
                {{"buffer": 0, "byteLength": 32, "byteStride": 4}},
                {{"buffer": 0, "byteOffset": 32, "byteLength": 36}},
                {{"buffer": 0, "byteOffset": 20, "byteLength": 4}}],
            "buffers": [{{"byteLength": 68}}]}}"#
        )
    };
    assert_eq!(soup(&good(&json(true, ""), &bytes)), soup(&raw));
    let whole = good(&json(false, ""), &bytes);
    assert!(
        whole
            .vertices
            .iter()
            .zip(&raw.vertices)
            .all(|(a, b)| *a == b * 127.0)
    );
    // Positions 5 and 7 become those that stand from byte 20 and 24 on: of vertices 5 and 6.
    bytes.extend([5, 7]);
    let sparse = r#", "sparse": {"count": 2, "indices": {"bufferView": 3, "componentType": 5121},
        "values": {"bufferView": 4}}"#;
    let views = json(true, sparse)
        .replace(
            r#""byteOffset": 20, "byteLength": 4}"#,
            r#""byteOffset": 20, "byteLength": 4},
            {"buffer": 0, "byteOffset": 68, "byteLength": 2},
            {"buffer": 0, "byteOffset": 20, "byteLength": 8, "byteStride": 4}"#,
        )
        .replace(r#""byteLength": 68}]"#, r#""byteLength": 70}]"#);
    let found = places(&good(&views, &bytes));
    let own: Vec<[f64; 3]> = raw.vertices.iter().map(|v| [v.x, v.y, v.z]).collect();
    assert_eq!((found[5], found[7], found[6]), (own[5], own[6], own[6]));
}

#[test]
fn sparse_values_without_a_view_replace_zeros() {
    // Positions 1 to 3 of the tetrahedron are sparse values, its corner at the origin the zeros behind them.
    let sparse = r#""sparse": {"count": 3, "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 3}},"#;
    let json = replaced(r#""bufferView": 0,"#, sparse)
        .replace(
            r#""byteLength": 48}],"#,
            r#""byteLength": 48}, {"buffer": 0, "byteOffset": 96, "byteLength": 3},
            {"buffer": 0, "byteOffset": 12, "byteLength": 36}],"#,
        )
        .replace(r#""byteLength": 96}]"#, r#""byteLength": 99}]"#);
    let bytes = [buffer(), vec![1, 2, 3]].concat();
    let raw = good(&json, &bytes);
    assert_eq!(soup(&raw), soup(&tetrahedron()));
    // Zeros beyond what the file could replace would only take memory.
    for count in ["101", "4000000000", "18446744073709551615"] {
        let many = json.replace(r#""count": 4,"#, &format!(r#""count": {count},"#));
        assert!(wrong(&many, &bytes).1.contains("more than the 100 bytes"));
    }
}

#[test]
fn compressed_meshes_are_refused_by_the_name_of_the_compression() {
    for (extension, name) in [
        ("KHR_draco_mesh_compression", "Draco"),
        ("EXT_meshopt_compression", "meshopt"),
    ] {
        let needed = format!(r#""scene": 0, "extensionsRequired": ["{extension}"]"#);
        let (_, what) = wrong(&replaced(r#""scene": 0"#, &needed), &buffer());
        assert!(what.contains(extension) && what.contains(name), "{what}");
    }
    let (_, what) = wrong(&replaced(r#""bufferView": 0,"#, ""), &buffer());
    assert!(what.contains("Draco"), "{what}");
}

#[test]
fn what_is_not_there_is_not_believed() {
    let accessor = Place::Item("accessors", 0);
    for (from, to, at, words) in [
        (
            r#""count": 4, "type": "VEC3""#,
            r#""count": 5, "type": "VEC3""#,
            accessor,
            "do not fit",
        ),
        (
            r#""count": 4,"#,
            r#""count": 18446744073709551615,"#,
            accessor,
            "do not fit",
        ),
        (
            r#""count": 4,"#,
            r#""byteOffset": 18446744073709551615, "count": 4,"#,
            accessor,
            "do not fit",
        ),
        (r#""bufferView": 0,"#, "", accessor, "no bufferView"),
        (
            r#""bufferView": 0,"#,
            r#""bufferView": 7,"#,
            Place::Item("bufferViews", 7),
            "does not exist",
        ),
        (
            r#""componentType": 5126"#,
            r#""componentType": 5125"#,
            accessor,
            "32-bit whole",
        ),
        (
            r#""componentType": 5126"#,
            r#""componentType": 77"#,
            accessor,
            "77 is not a component",
        ),
        (
            r#""componentType": 5125"#,
            r#""componentType": 5126"#,
            Place::Item("accessors", 1),
            "plain 8",
        ),
        (
            r#""POSITION": 0"#,
            r#""POSITION": 9"#,
            Place::Item("accessors", 9),
            "does not exist",
        ),
        (
            r#""POSITION": 0"#,
            r#""POSITION": 1"#,
            Place::Item("accessors", 1),
            "another type",
        ),
        (
            r#""count": 12"#,
            r#""count": 11"#,
            Place::Item("meshes", 0),
            "do not make whole triangles",
        ),
        (
            r#""byteLength": 48}"#,
            r#""byteLength": 4800}"#,
            Place::Item("bufferViews", 0),
            "not within",
        ),
        (
            r#""byteLength": 48}"#,
            r#""byteLength": 48, "byteStride": 4}"#,
            accessor,
            "every 4 bytes",
        ),
        (
            r#"{ "byteLength": 96}"#,
            r#"{"byteLength": 9600}"#,
            Place::Item("buffers", 0),
            "promises 9600",
        ),
        (
            r#"{ "byteLength": 96}"#,
            r#"{"uri": "../a.bin", "byteLength": 96}"#,
            Place::Item("buffers", 0),
            "`../a.bin`",
        ),
        (
            r#"{ "byteLength": 96}"#,
            r#"{"uri": "data:;base64,A*", "byteLength": 96}"#,
            Place::Item("buffers", 0),
            "base64",
        ),
        (
            r#""version": "2.0""#,
            r#""version": "1.0""#,
            Place::Item("asset", 0),
            "version 1.0",
        ),
        (
            r#""mesh": 0"#,
            r#""mesh": 3"#,
            Place::Item("meshes", 3),
            "does not exist",
        ),
        (
            r#""mesh": 0"#,
            r#""children": [0]"#,
            Place::Item("nodes", 0),
            "reached twice",
        ),
        (
            r#""mesh": 0"#,
            r#""children": [5]"#,
            Place::Item("nodes", 5),
            "does not exist",
        ),
        (
            r#""mesh": 0"#,
            r#""rotation": [0, 0, 0, 0]"#,
            Place::Item("nodes", 0),
            "quaternion",
        ),
        (
            r#""mesh": 0"#,
            r#""matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]"#,
            Place::Item("nodes", 0),
            "affine",
        ),
        (
            r#""scene": 0"#,
            r#""scene": 4"#,
            Place::Item("scenes", 4),
            "does not exist",
        ),
        (
            r#""indices": 1}"#,
            r#""indices": 1, "mode": 7}"#,
            Place::Item("meshes", 0),
            "7 is not a primitive",
        ),
        (
            r#""scene": 0"#,
            r#""extensionsRequired": ["KHR_draco_mesh_compression"]"#,
            Place::Item("extensionsRequired", 0),
            "KHR_draco_mesh_compression",
        ),
    ] {
        let (found, what) = wrong(&replaced(from, to), &buffer());
        assert!(
            found == at && what.contains(words),
            "{to}: {found:?} {what}"
        );
    }
    let (at, what) = wrong(r#"{"asset": {"version": "2.0"}, "nodes": 3}"#, &[]);
    assert!(at == Place::Line(1) && what.contains("column"), "{what}");
    let mut bytes = buffer();
    bytes[48] = 200;
    let (at, what) = wrong(&gltf_json(&tetrahedron(), ""), &bytes);
    assert!(
        at == Place::Item("accessors", 1) && what.contains("vertex 200"),
        "{what}"
    );
}

#[test]
fn depth_and_length_are_bounded() {
    let chain: Vec<String> = (1..100_000)
        .map(|next| format!(r#"{{"children": [{next}]}}"#))
        .collect();
    let chain = format!(r#""nodes": [{}, {{"mesh": 0}}]"#, chain.join(","));
    assert_eq!(good(&replaced(NODES, &chain), &buffer()).triangles.len(), 4);
    let deep = format!(
        r#"{{"asset": {{"version": "2.0", "extras": {}"#,
        "[".repeat(100_000)
    );
    assert!(wrong(&deep, &[]).1.contains("the JSON cannot be used"));
    let many = format!(r#""nodes": [{}{{}}]"#, "{},".repeat(300_000));
    assert!(
        wrong(&replaced(NODES, &many), &buffer())
            .1
            .contains("at most 262144")
    );
}
