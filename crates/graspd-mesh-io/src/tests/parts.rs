//! The named parts that the readers find.

use super::*;

/// The name of the part of each triangle.
fn parts(bytes: impl AsRef<[u8]>) -> Vec<Option<String>> {
    let (_, raw) = good(bytes);
    let name = |triangle| Some(raw.parts.names()[raw.parts.of(triangle)?].clone());
    (0..raw.triangles.len()).map(name).collect()
}

/// Expected parts: so many triangles of each name.
fn runs(runs: &[(&str, usize)]) -> Vec<Option<String>> {
    let of = |&(name, count): &(&str, usize)| {
        let name = (!name.is_empty()).then(|| name.to_owned());
        std::iter::repeat_n(name, count)
    };
    runs.iter().flat_map(of).collect()
}

#[test]
fn groups_of_obj_may_be_resumed_and_objects_come_first() {
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let groups =
        "f 1 2 3\ng  left  arm \nf 1 2 3 4\ng right\nf 1 2 3\ng left arm\nf 1 2 3\ng\nf 1 2 3\n";
    let wanted = [
        ("", 1),
        ("left arm", 2),
        ("right", 1),
        ("left arm", 1),
        ("", 1),
    ];
    assert_eq!(parts(format!("{corners}{groups}")), runs(&wanted));
    let objects =
        "g a\nf 1 2 3\no mug\ng body\nf 1 2 3\ng handle # of it\nf 1 2 3\no lid\nf 1 2 3\n";
    let wanted = [("a", 1), ("mug", 2), ("lid", 1)];
    assert_eq!(parts(format!("{corners}{objects}")), runs(&wanted));
}

#[test]
fn solids_of_stl_are_parts_even_where_names_repeat() {
    let text = ["lid", "lid", "", "lid (2)"].map(|name| stl_ascii(&tetrahedron(), name));
    let wanted = [("lid", 4), ("lid (2)", 4), ("", 4), ("lid (2) (2)", 4)];
    assert_eq!(parts(text.concat()), runs(&wanted));
    let binary =
        ["solid cup", "", "lid\0of something"].map(|name| stl_binary(&tetrahedron(), name));
    let wanted = [("cup", 4), ("", 4), ("lid", 4)];
    assert_eq!(parts(binary.concat()), runs(&wanted));
    // The header of a single solid is rarely its name.
    assert_eq!(
        parts(stl_binary(&tetrahedron(), "made by a program")),
        runs(&[("", 4)])
    );
}

#[test]
fn nodes_of_gltf_name_parts_by_themselves_their_mesh_or_a_node_above() {
    let json = gltf_json(&tetrahedron(), "");
    let nodes = r#""nodes": [{"name": "part", "mesh": 0}, {"name": "part", "mesh": 0}, {"mesh": 0},
        {"name": "above", "children": [4]}, {"name": "", "mesh": 0}]"#;
    let several = json
        .replace(r#"[{"nodes": [0]}]"#, r#"[{"nodes": [0, 1, 2, 3]}]"#)
        .replace(r#""nodes": [{"mesh": 0, "name": "part"}]"#, nodes);
    let wanted = [("part", 4), ("part (2)", 4), ("", 4), ("above", 4)];
    assert_eq!(
        parts(glb_of(&several, &gltf_buffer(&tetrahedron()))),
        runs(&wanted)
    );
    let named = several.replace(r#""meshes": [{"#, r#""meshes": [{"name": "shape", "#);
    let wanted = [("part", 4), ("part (2)", 4), ("shape", 4), ("shape (2)", 4)];
    assert_eq!(
        parts(glb_of(&named, &gltf_buffer(&tetrahedron()))),
        runs(&wanted)
    );
}

#[test]
fn names_are_fit_to_be_shown() {
    let long = "ä".repeat(300);
    let shown = "ä".repeat(100);
    for (name, wanted) in [
        (long.as_bytes(), shown.as_str()),
        (b"caf\xE9".as_slice(), "caf\u{FFFD}"),
        ("a\u{202E}b\u{7}c".as_bytes(), "abc"),
        ("\u{200E}".as_bytes(), ""),
    ] {
        let file = [b"v 0 0 0\nv 1 0 0\nv 0 1 0\no ", name, b"\nf 1 2 3\n"].concat();
        assert_eq!(parts(file), runs(&[(wanted, 1)]));
    }
}

#[test]
fn names_count_as_memory() {
    let mut file = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for n in 0..50_000 {
        file += &format!("o {}{n}\nf 1 2 3\n", "x".repeat(90));
    }
    let limits = Limits {
        memory: 10_000_000,
        ..Limits::NONE
    };
    let error = read(file.as_bytes(), None, &limits).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { .. }), "{error}");
}
