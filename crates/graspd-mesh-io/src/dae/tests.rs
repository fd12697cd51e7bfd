//! Scenes of all shapes, and documents that promise what they do not have.

use graspd_core::mesh::RawMesh;
use graspd_core::mesh::solids::{cube, soup, tetrahedron};
use nalgebra::Point3;

use crate::tests::files::{dae, dae_geometry, dae_of, dae_triangles};
use crate::{Limits, MeshFormat, Place, ReadError, read};

const LIMITS: Limits = Limits {
    triangles: 1000,
    vertices: 1000,
    ..Limits::NONE
};

fn good(text: &str) -> RawMesh {
    let (format, raw) = read(text.as_bytes(), None, &LIMITS).unwrap();
    assert_eq!(format, MeshFormat::Dae);
    raw
}

fn wrong(text: &str) -> String {
    match read(text.as_bytes(), None, &LIMITS).unwrap_err() {
        ReadError::Malformed {
            format: MeshFormat::Dae,
            at: Place::Byte(_),
            what,
        } => what,
        other => panic!("{other:?}"),
    }
}

/// The tetrahedron in a scene of these nodes.
fn scene(nodes: &str) -> String {
    let own = tetrahedron();
    dae_of(&dae_geometry(&own, &dae_triangles(&own)), nodes)
}

/// The tetrahedron with these primitives.
fn primitives(text: &str) -> String {
    let inputs = r##"<input semantic="VERTEX" source="#vertices" offset="1"/>
        <input semantic="NORMAL" source="#normals" offset="0"/>"##;
    dae_of(
        &dae_geometry(&tetrahedron(), &text.replace("INPUTS", inputs)),
        "",
    )
}

const INSTANCE: &str = r##"<instance_geometry url="#shape"><bind_material><p>x</p></bind_material></instance_geometry>"##;

/// The names of the parts, each with as many triangles as a tetrahedron has.
fn parts(raw: &RawMesh) -> Vec<&str> {
    let name = |n| {
        raw.parts
            .of(n)
            .map_or("", |part| raw.parts.names()[part].as_str())
    };
    (0..raw.triangles.len()).step_by(4).map(name).collect()
}

#[test]
fn every_kind_of_primitive_is_read() {
    let own = tetrahedron();
    // Each corner with the number of a normal before that of its position.
    let list = |t: &[u32]| {
        t.iter()
            .map(|index| format!("9 {index} "))
            .collect::<String>()
    };
    let flat: Vec<u32> = own.triangles.iter().flatten().copied().collect();
    let lists: String = own
        .triangles
        .iter()
        .map(|t| format!("<p>{}</p>", list(t)))
        .collect();
    for text in [
        format!("<triangles>INPUTS<p>{}</p></triangles>", list(&flat)),
        format!(
            "<polylist>INPUTS<vcount>3 3 3 3</vcount><p>{}</p></polylist>",
            list(&flat)
        ),
        format!("<polygons>INPUTS{lists}</polygons>"),
        format!("<trifans>INPUTS{lists}</trifans>"),
        format!("<tristrips>INPUTS{lists}</tristrips>"),
        format!(
            "<lines>INPUTS<p>0 0 1 1</p></lines><triangles>INPUTS<p>{}</p></triangles>",
            list(&flat)
        ),
    ] {
        assert_eq!(soup(&good(&primitives(&text))), soup(&own), "{text}");
    }
    let raw = good(&primitives(&format!(
        "<tristrips>INPUTS<p>{}</p></tristrips>",
        list(&[0, 1, 2, 3])
    )));
    assert_eq!(raw.triangles, [[0, 1, 2], [2, 1, 3]]);
    let raw = good(&primitives(&format!(
        "<trifans>INPUTS<p>{}</p></trifans>",
        list(&[0, 1, 2, 3])
    )));
    assert_eq!(raw.triangles, [[0, 1, 2], [0, 2, 3]]);
    let square = "<polylist>INPUTS<vcount>4</vcount><p>9 0 9 1 9 3 9 2</p></polylist>";
    assert_eq!(good(&primitives(square)).triangles.len(), 2);
}

#[test]
fn transforms_of_nodes_multiply_in_their_order() {
    let own = tetrahedron();
    let factors = format!(
        r#"<node><translate>5 0 0</translate><node><rotate>0 0 1 90</rotate><scale>2 2 2</scale>{INSTANCE}</node></node>"#
    );
    let matrix =
        format!("<node><matrix>0 -2 0 5  2 0 0 0  0 0 2 0  0 0 0 1</matrix>{INSTANCE}</node>");
    for nodes in [factors, matrix] {
        let raw = good(&scene(&nodes));
        for (found, own) in raw.vertices.iter().zip(&own.vertices) {
            let wanted = Point3::new(5.0 - 2.0 * own.y, 2.0 * own.x, 2.0 * own.z);
            assert!((found - wanted).norm() < 1e-14, "{found} {wanted}");
        }
        assert_eq!(raw.triangles, own.triangles);
    }
    let mirror = good(&scene(&format!(
        "<node><scale>-1 1 1</scale>{INSTANCE}</node>"
    )));
    let backwards: Vec<[u32; 3]> = own.triangles.iter().map(|&[a, b, c]| [c, b, a]).collect();
    assert_eq!(mirror.triangles, backwards);
}

#[test]
fn nodes_geometries_and_skins_are_placed_as_often_as_they_are_wanted() {
    let nodes = format!(
        r##"<node name="cup">{INSTANCE}</node><node name="cup">{INSTANCE}</node>
        <node id="arm"><node>{INSTANCE}</node></node><node name="copy"><instance_node url="#shared"/></node>
        <node name="skin"><instance_controller url="#bent"/></node>"##
    );
    let libraries = format!(
        r##"<library_nodes><node id="shared" name="shared">{INSTANCE}</node></library_nodes>
        <library_controllers><controller id="bent"><skin source="#shape">
        <bind_shape_matrix>1 0 0 7 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix></skin></controller></library_controllers>
        <library_visual_scenes>"##
    );
    let raw = good(&scene(&nodes).replace("<library_visual_scenes>", &libraries));
    assert_eq!(parts(&raw), ["cup", "cup (2)", "arm", "shared", "skin"]);
    assert_eq!(
        raw.vertices[16],
        tetrahedron().vertices[0] + nalgebra::Vector3::new(7.0, 0.0, 0.0)
    );
    // Without a scene, all geometries count, by their own names.
    let raw = good(&scene(""));
    assert_eq!((raw.triangles.len(), parts(&raw)), (4, vec!["shape"]));
}

#[test]
fn the_frame_and_the_unit_are_those_of_the_file() {
    // The document says inches with y up; the other formats have no such thing, and so nothing is converted.
    assert_eq!(good(&dae(&cube(3.0))).vertices, cube(3.0).vertices);
}

#[test]
fn what_is_wrong_is_named() {
    let plain = dae(&tetrahedron());
    for (from, to, part) in [
        (
            "url=\"#shape\"",
            "url=\"other.dae#shape\"",
            "`other.dae#shape`, another file",
        ),
        (
            "url=\"#scene\"",
            "url=\"file:///etc/passwd\"",
            "never opened",
        ),
        ("url=\"#shape\"", "url=\"#shop\"", "no geometry of that id"),
        (
            "url=\"#shape\"",
            "url=\"#vertices\"",
            "no geometry of that id",
        ),
        (
            "source=\"#positions\"",
            "source=\"#numbers\"",
            "no source of that id",
        ),
        (
            "semantic=\"POSITION\"",
            "semantic=\"NORMAL\"",
            "no positions",
        ),
        ("count=\"4\" stride", "count=\"5\" stride", "do not fit"),
        (
            "count=\"4\" stride",
            "count=\"18446744073709551615\" stride",
            "do not fit",
        ),
        ("stride=\"3\"", "stride=\"2\"", "do not fit"),
        ("stride=\"3\"", "stride=\"x\"", "`x` is not a whole number"),
        ("offset=\"0\"", "offset=\"100\"", "more than 64 numbers"),
        ("offset=\"0\"", "offset=\"4\"", "do not make whole corners"),
        ("<p>0 2 1", "<p>0 2 1 0", "do not make whole faces"),
        ("<p>0 2 1", "<p>0 2 4", "vertex 4"),
        ("<p>0 2 1", "<p>0 2 -1", "`-1`"),
        (
            "count=\"12\">0 0 0",
            "count=\"12\">0,5 0 0",
            "decimal comma",
        ),
        (
            "count=\"12\">0 0 0",
            "count=\"12\">nan 0 0",
            "not a finite number",
        ),
        (
            "<p>0 2 1",
            "<ph><p>0 2 1</p><h>1 2 3</h></ph><p>0 2 1",
            "has holes",
        ),
        (
            "<instance_geometry",
            "<lookat>1 2 3</lookat><instance_geometry",
            "<lookat>",
        ),
        (
            "<instance_geometry",
            "<matrix>1 2 3</matrix><instance_geometry",
            "fewer than 16",
        ),
        (
            "<instance_geometry",
            "<rotate>0 0 0 90</rotate><instance_geometry",
            "no axis",
        ),
        (
            "<?xml version=\"1.0\"?>",
            "<!DOCTYPE a [<!ENTITY b \"c\">]>",
            "document type",
        ),
        ("</node>", "</nod>", "cannot be read"),
        ("</COLLADA>", "", "ends inside"),
    ] {
        assert!(plain.contains(from), "{from}");
        let what = wrong(&plain.replacen(from, to, 1));
        assert!(what.contains(part), "{to}: {what}");
    }
    let unclosed = wrong(&plain[..plain.len() / 2]);
    assert!(
        unclosed.contains("cannot be read") || unclosed.contains("ends inside"),
        "{unclosed}"
    );
    // A fault may quote the file, but never much of it.
    let long = plain.replacen("</node>", &format!("</{}>", "n\u{7}".repeat(1000)), 1);
    assert!(wrong(&long).len() < 300);
    let mut latin = plain.into_bytes();
    let at = latin.windows(6).position(|w| w == b"\"part\"").unwrap();
    latin[at + 1] = 0xE9;
    let error = read(&latin, None, &LIMITS).unwrap_err();
    assert!(error.to_string().contains("not UTF-8"), "{error}");
}

#[test]
fn depth_repetition_and_memory_are_bounded() {
    let deep = "<node>".repeat(50_000) + INSTANCE + &"</node>".repeat(50_000);
    assert_eq!(good(&scene(&deep)).triangles.len(), 4);
    let what = wrong(&scene(
        r##"<node id="a"><instance_node url="#a"/><instance_node url="#a"/></node>"##,
    ));
    assert!(what.contains("more than 65536 nodes"), "{what}");
    let limits = Limits {
        memory: 1 << 20,
        ..Limits::NONE
    };
    let many = scene(&"<node/>".repeat(100_000));
    let error = read(many.as_bytes(), None, &limits).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { .. }), "{error}");
    // Attributes are not compared with each other, which would take the square of their number.
    let attributes: String = (0..200_000).map(|n| format!(" a{n}=''")).collect();
    assert_eq!(
        good(&scene(&format!("<node{attributes}>{INSTANCE}</node>")))
            .triangles
            .len(),
        4
    );
}
