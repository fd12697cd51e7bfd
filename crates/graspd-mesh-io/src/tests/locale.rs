//! Decimal commas, first statements of OBJ, and points without faces.

use super::*;

#[test]
fn decimal_commas_are_named() {
    let raw = moved(&cube(1.0), [0.5; 3]);
    let comma = |text: String| {
        let lines = text
            .lines()
            .map(|line| match line.contains("0.5") || line.contains("e-1") {
                true => line.replace('.', ",") + "\n",
                false => line.to_owned() + "\n",
            });
        lines.collect::<String>()
    };
    let stl = stl_ascii(&raw, "part").replace("vertex 5e-1", "vertex 5.0e-1");
    for text in [stl, obj(&raw), ply_ascii(&raw), off(&raw)] {
        let text = comma(text);
        assert!(text.contains(','), "{text}");
        let (_, what) = malformed(text);
        assert!(what.contains("decimal comma"), "{what}");
    }
    // A list of numbers is none.
    let (_, what) = malformed("v 1,2,3 0 0\nv 0 1 0\nf 1 2 3\n");
    assert!(
        what.contains("`1,2,3`") && !what.contains("decimal"),
        "{what}"
    );
}

#[test]
fn obj_may_begin_with_any_statement_or_with_words() {
    let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for first in [
        "bevel off",
        "call other.obj",
        "csh ls",
        "curv 0 1 2",
        "deg 3",
        "lod 1",
        "maplib a",
        "shadow_obj a",
        "step 1",
        "end",
        "Wavefront OBJ exported by some program",
        "version 1",
        "o part",
        "vt 0 0",
        "ctech cspace 1",
    ] {
        let text = format!("{first}\n\n{plain}");
        assert_eq!(good(&text).0, MeshFormat::Obj, "{first}");
        assert_eq!(
            read(text.as_bytes(), Some(MeshFormat::Obj), &LIMITS)
                .unwrap()
                .1
                .triangles,
            [[0, 1, 2]]
        );
    }
    for prose in [
        "A letter\nv 1 2\nf 1\n",
        "see chapter\nv 5\nf for failure\n",
    ] {
        not_a_mesh(prose);
    }
}

#[test]
fn points_without_faces_are_named() {
    let mut raw = cube(1.0);
    raw.triangles.clear();
    for (format, text) in [
        (MeshFormat::Obj, obj(&raw)),
        (MeshFormat::Ply, ply_ascii(&raw)),
        (MeshFormat::Off, off(&raw)),
    ] {
        let error = bad(text);
        assert_eq!(error, ReadError::PointCloud { format, points: 8 });
        assert!(
            error.to_string().contains("8 points and no face"),
            "{error}"
        );
    }
}
