//! Packages of all shapes, and packages that promise what they do not have.

use graspd_core::mesh::WarningKind;
use graspd_core::mesh::solids::{cube, flipped, join, moved, tetrahedron};

use crate::tests::files::{archive, threemf_mesh, threemf_model, threemf_of};
use crate::{Limits, MeshFormat, Place, ReadError, read};
use graspd_core::mesh::RawMesh;

const LIMITS: Limits = Limits {
    triangles: 1000,
    vertices: 1000,
    ..Limits::NONE
};

fn good(bytes: &[u8]) -> RawMesh {
    let (format, raw) = read(bytes, None, &LIMITS).unwrap();
    assert_eq!(format, MeshFormat::ThreeMf);
    raw
}

fn wrong(bytes: &[u8]) -> (Place, String) {
    match read(bytes, None, &LIMITS).unwrap_err() {
        ReadError::Malformed {
            format: MeshFormat::ThreeMf,
            at,
            what,
        } => (at, what),
        other => panic!("{other:?}"),
    }
}

fn model(objects: &str, items: &str) -> Vec<u8> {
    threemf_of(&threemf_model(objects, items))
}

/// The names of the parts and how many triangles each has; "" for none.
fn parts(raw: &RawMesh) -> Vec<(String, usize)> {
    let mut runs: Vec<(String, usize)> = Vec::new();
    for triangle in 0..raw.triangles.len() {
        let name = raw
            .parts
            .of(triangle)
            .map_or("", |part| &raw.parts.names()[part]);
        match runs.last_mut() {
            Some((last, count)) if last == name => *count += 1,
            _ => runs.push((name.to_owned(), 1)),
        }
    }
    runs
}

fn tetrahedra(ids: &[(u32, &str)]) -> String {
    let mesh = threemf_mesh(&tetrahedron());
    let objects = ids
        .iter()
        .map(|(id, name)| format!(r#"<object id="{id}" name="{name}">{mesh}</object>"#));
    objects.collect()
}

#[test]
fn items_and_components_are_moved_turned_and_mirrored() {
    let assembly = r#"<object id="2" name="pair"><components>
        <component objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 7"/>
        <component objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/></components></object>"#;
    let items = r#"<item objectid="2" transform="0 2 0 -2 0 0 0 0 2 5 0 0"/><item objectid="1"/>"#;
    let raw = good(&model(&(tetrahedra(&[(1, "")]) + assembly), items));
    let own = tetrahedron();
    // Doubled, turned by a quarter about z and moved by 5, after what the component did.
    let turned = |raw: &RawMesh| {
        let mut raw = raw.clone();
        for v in &mut raw.vertices {
            *v = nalgebra::Point3::new(5.0 - 2.0 * v.y, 2.0 * v.x, 2.0 * v.z);
        }
        raw
    };
    let mut mirrored = own.clone();
    mirrored.vertices.iter_mut().for_each(|v| v.x = -v.x);
    let wanted = join(&[
        turned(&moved(&own, [0.0, 0.0, 7.0])),
        turned(&flipped(&mirrored)),
        own,
    ]);
    assert_eq!(raw.vertices, wanted.vertices);
    // A mirrored face runs backwards, from whichever corner it begins.
    let runs = |raw: &RawMesh| -> Vec<[u32; 3]> {
        let smallest_first = |t: &[u32; 3]| {
            let at = (0..3).min_by_key(|&n| t[n]).unwrap_or_default();
            [t[at], t[(at + 1) % 3], t[(at + 2) % 3]]
        };
        raw.triangles.iter().map(smallest_first).collect()
    };
    assert_eq!(runs(&raw), runs(&wanted));
    assert_eq!(
        parts(&raw),
        [
            ("pair".to_owned(), 4),
            ("pair (2)".to_owned(), 4),
            (String::new(), 4)
        ]
    );
}

#[test]
fn objects_name_parts_and_supports_are_left_out() {
    let objects = tetrahedra(&[(1, "cup"), (2, "a &amp; b"), (3, "")]);
    let support = format!(
        r#"<object id="4" type="support">{}</object>"#,
        threemf_mesh(&cube(1.0))
    );
    let items = r#"<item objectid="2"/><item objectid="1"/><item objectid="4"/><item objectid="1"/><item objectid="3"/>"#;
    let raw = good(&model(&(objects.clone() + &support), items));
    let wanted = [("a & b", 4), ("cup", 4), ("cup (2)", 4), ("", 4)];
    assert_eq!(
        parts(&raw),
        wanted.map(|(name, count)| (name.to_owned(), count))
    );
    let [warning] = &raw.warnings[..] else {
        panic!("{:?}", raw.warnings);
    };
    assert!(
        warning.kind == WarningKind::File && warning.detail.starts_with("1 objects were left out")
    );
    // Without build items, what is no component counts.
    let holder = r#"<object id="9" name="holder"><components><component objectid="1"/></components></object>"#;
    let raw = good(&model(&(objects + holder), ""));
    let wanted = [("a & b", 4), ("", 4), ("cup", 4)];
    assert_eq!(
        parts(&raw),
        wanted.map(|(name, count)| (name.to_owned(), count))
    );
}

#[test]
fn objects_may_be_in_other_models_of_the_archive() {
    let holder = r#"<object id="1"><components><component p:path="/3D/Objects/One.model" objectid="5"/></components></object>"#;
    let root = threemf_model(
        holder,
        r#"<item objectid="1"/><item p:path="/3d/objects/one.MODEL" objectid="6"/>"#,
    );
    let other = threemf_model(&tetrahedra(&[(5, "five"), (6, "six")]), "");
    let raw = good(&archive(&[
        ("3D/3dmodel.model", root.as_bytes()),
        ("3D/Objects/One.model", other.as_bytes()),
    ]));
    assert_eq!(parts(&raw), [("five".to_owned(), 4), ("six".to_owned(), 4)]);
    let (_, what) = wrong(&archive(&[("3D/3dmodel.model", root.as_bytes())]));
    assert!(
        what.contains("3d/objects/one.model is referred to"),
        "{what}"
    );
    // A path never leaves the archive.
    let outside = root.replace("/3D/Objects/One.model", "/../../etc/passwd");
    let (_, what) = wrong(&archive(&[("3D/3dmodel.model", outside.as_bytes())]));
    assert!(what.contains("is not in the archive"), "{what}");
}

#[test]
fn prefixes_and_extensions_are_understood() {
    let plain = threemf_model(&tetrahedra(&[(1, "a")]), r#"<item objectid="1"/>"#);
    let prefixed = plain
        .replace("</", "\u{1}")
        .replace('<', "<core:")
        .replace('\u{1}', "</core:")
        .replace("<core:?xml", "<?xml")
        .replace("xmlns=", "xmlns:core=");
    assert_eq!(good(&threemf_of(&prefixed)), good(&threemf_of(&plain)));
    // Elements of extensions are none of the core, whatever their names.
    let foreign = plain.replace(
        "<triangles>",
        r#"<triangles><d:triangle v1="0" v2="1" v3="2"/>"#,
    );
    assert_eq!(good(&threemf_of(&foreign)), good(&threemf_of(&plain)));
    let required = plain.replace(
        r#"requiredextensions="p""#,
        r#"xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02" requiredextensions="p b""#,
    );
    let (_, what) = wrong(&threemf_of(&required));
    assert!(what.contains("extension b (http://schemas"), "{what}");
}

#[test]
fn what_is_wrong_is_named() {
    let plain = threemf_model(&tetrahedra(&[(1, "a")]), r#"<item objectid="1"/>"#);
    let object = Place::Object(1);
    for (from, to, at, part) in [
        (r#"v3="3""#, r#"v3="4""#, object, "vertex 4"),
        (r#"v3="3""#, r#"v3="-1""#, object, "`-1`"),
        (r#"v3="3""#, "", object, "v1, v2, v3 is missing"),
        (r#"x="1""#, r#"x="1,5""#, object, "decimal comma"),
        (r#"x="1""#, r#"x="nan""#, object, "not a finite"),
        (r#"x="1""#, r#"x="1e31""#, object, "greatest"),
        (
            r#"item objectid="1""#,
            r#"item objectid="2""#,
            Place::Object(2),
            "does not exist",
        ),
        (
            r#"item objectid="1""#,
            r#"item objectid="1" transform="1 0 0""#,
            object,
            "twelve numbers",
        ),
        (
            r#"object id="1""#,
            r#"object id="one""#,
            Place::Unpacked(0),
            "`one`",
        ),
        (
            "</resources>",
            r#"<object id="1"/></resources>"#,
            object,
            "another object",
        ),
        ("<model ", "<html ", Place::Unpacked(0), "<html>"),
    ] {
        assert!(plain.contains(from), "{from}");
        let (found, what) = wrong(&threemf_of(&plain.replacen(from, to, 1)));
        assert!(found == at && what.contains(part), "{to}: {found} {what}");
    }
    let entity = plain.replacen("<model", "<!DOCTYPE model [<!ENTITY a \"aaaa\">]><model", 1);
    assert!(wrong(&threemf_of(&entity)).1.contains("document type"));
    let (_, what) = wrong(&threemf_of(&plain[..plain.len() / 2]));
    assert!(
        what.contains("cannot be read") || what.contains("ends inside"),
        "{what}"
    );
    let mut damaged = threemf_of(&plain);
    let at = damaged.windows(4).position(|w| w == b"PK\x01\x02").unwrap() / 2;
    damaged[at] ^= 0x55;
    assert!(read(&damaged, None, &LIMITS).is_err());
}

#[test]
fn archives_without_a_model_are_named() {
    for (name, words) in [
        ("word/document.xml", "a zip archive"),
        ("parts/body.stl", "such as parts/body.stl"),
        ("scene.usdc", "a USDZ file"),
    ] {
        for declared in [None, Some(MeshFormat::Stl)] {
            let error = read(&archive(&[(name, b"")]), declared, &LIMITS).unwrap_err();
            assert!(matches!(error, ReadError::NotAMesh { .. }), "{error}");
            assert!(error.to_string().contains(words), "{error}");
        }
    }
}

#[test]
fn a_small_archive_does_not_become_large() {
    // 200 MB of spaces in 200 KB; in one text, and between tags.
    let spaces = " ".repeat(200 << 20);
    let bytes = threemf_of(&threemf_model(&spaces, ""));
    assert!(bytes.len() < 1 << 20);
    let (_, what) = wrong(&bytes);
    assert!(what.contains("one tag or text"), "{what}");
    let tags = "<a/>".repeat(25 << 20);
    let bytes = threemf_of(&threemf_model(&tags, ""));
    assert!(bytes.len() < 1 << 20);
    let (_, what) = wrong(&bytes);
    assert!(what.contains("more than 100 times its size"), "{what}");
    // Vertices that no triangle uses count as well.
    let vertices = r#"<vertex x="0" y="0" z="0"/>"#.repeat(100_000);
    let objects =
        format!(r#"<object id="1"><mesh><vertices>{vertices}</vertices></mesh></object>"#);
    let limits = Limits {
        memory: 1 << 20,
        ..Limits::NONE
    };
    let error = read(&model(&objects, ""), None, &limits).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { .. }), "{error}");
}

#[test]
fn objects_that_multiply_or_contain_each_other_end() {
    // Each object has two of the one before: 2^40 of the first, which is empty.
    let mut objects = String::from(r#"<object id="1"/>"#);
    for id in 2..42 {
        let below = format!(r#"<component objectid="{}"/>"#, id - 1);
        objects +=
            &format!(r#"<object id="{id}"><components>{below}{below}</components></object>"#);
    }
    let (_, what) = wrong(&model(&objects, r#"<item objectid="41"/>"#));
    assert!(what.contains("more than 65536 components"), "{what}");
    let circle = r#"<object id="1"><components><component objectid="1"/><component objectid="1"/></components></object>"#;
    let (_, what) = wrong(&model(circle, r#"<item objectid="1"/>"#));
    assert!(what.contains("contain each other"), "{what}");
    // With triangles, the limits end it.
    let full = objects.replace(r#"<object id="1"/>"#, &tetrahedra(&[(1, "")]));
    let error = read(&model(&full, r#"<item objectid="41"/>"#), None, &LIMITS).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { .. }), "{error}");
}
