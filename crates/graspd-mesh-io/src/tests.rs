//! Every format in its odd variants, and everything that is no mesh.

use std::sync::atomic::{AtomicUsize, Ordering};

pub(crate) mod files;
mod foreign;
mod locale;
mod off;
mod parts;
mod precision;
mod stl;
mod strips;

use proptest::prelude::*;

use super::*;
use files::*;
use graspd_core::Interrupted;
use graspd_core::mesh::Mesh;
use graspd_core::mesh::solids::*;

const LIMITS: Limits = Limits {
    triangles: 100_000,
    vertices: 100_000,
    ..Limits::NONE
};

fn good(bytes: impl AsRef<[u8]>) -> (MeshFormat, RawMesh) {
    read(bytes.as_ref(), None, &LIMITS).unwrap()
}

fn bad(bytes: impl AsRef<[u8]>) -> ReadError {
    read(bytes.as_ref(), None, &LIMITS).unwrap_err()
}

fn not_a_mesh(bytes: impl AsRef<[u8]>) -> String {
    match bad(bytes) {
        error @ ReadError::NotAMesh { .. } => error.to_string(),
        other => panic!("{other:?}"),
    }
}

fn malformed(bytes: impl AsRef<[u8]>) -> (Place, String) {
    match bad(bytes) {
        ReadError::Malformed { at, what, .. } => (at, what),
        other => panic!("{other:?}"),
    }
}

/// The L in every format; volume 3.
fn variants() -> Vec<(MeshFormat, Vec<u8>)> {
    let raw = l_shape();
    vec![
        (MeshFormat::Stl, stl_binary(&raw, "made by code")),
        (MeshFormat::Stl, stl_binary(&raw, "solid facet endsolid")),
        (MeshFormat::Stl, stl_ascii(&raw, "part").into()),
        (MeshFormat::Obj, obj(&raw).into()),
        (MeshFormat::Ply, ply_ascii(&raw).into()),
        (MeshFormat::Ply, ply_binary(&raw, false)),
        (MeshFormat::Ply, ply_binary(&raw, true)),
        (MeshFormat::Off, off(&raw).into()),
        (MeshFormat::Glb, glb(&raw)),
        (MeshFormat::Gltf, gltf(&raw).into()),
        (MeshFormat::ThreeMf, threemf(&raw)),
        (MeshFormat::Dae, dae(&raw).into()),
    ]
}

#[test]
fn names_of_formats_go_both_ways() {
    for format in MeshFormat::ALL {
        assert_eq!(MeshFormat::from_name(format.name()), Some(format));
        assert_eq!(MeshFormat::from_name(&format.to_string()), Some(format));
        assert_eq!(
            MeshFormat::from_media_type(format.media_type()),
            Some(format)
        );
        let json = serde_json::to_string(&format).unwrap();
        assert_eq!(json, format!("{:?}", format.name()));
    }
    assert_eq!(MeshFormat::from_name("step"), None);
    let listed = |names: Vec<String>| {
        let (last, others) = names.split_last().unwrap();
        format!("{} or {last}", others.join(", "))
    };
    let names = MeshFormat::ALL.map(|format| format.name().to_owned());
    assert_eq!(MeshFormat::NAMES, listed(names.into()));
    let titles = MeshFormat::ALL.map(|format| format.to_string());
    assert_eq!(MeshFormat::TITLES, listed(titles.into()));
}

#[test]
fn every_format_gives_the_same_triangles() {
    for (format, bytes) in variants() {
        let (found, raw) = good(&bytes);
        assert_eq!(found, format);
        assert_eq!(read(&bytes, Some(format), &LIMITS).unwrap().0, format);
        assert_eq!(soup(&raw), soup(&l_shape()));
        assert!(Mesh::prepare(raw).unwrap().report().watertight);
    }
}

#[test]
fn a_sender_who_contradicts_the_content_is_told() {
    for (format, bytes) in variants() {
        for said in MeshFormat::ALL.into_iter().filter(|&said| said != format) {
            let error = read(&bytes, Some(said), &LIMITS).unwrap_err();
            let text = error.to_string();
            assert!(matches!(error, ReadError::NotAMesh { .. }), "{text}");
            assert!(text.contains(&said.to_string()) && text.contains(&format.to_string()));
        }
    }
}

#[test]
fn binary_stl_may_have_a_trailer_and_any_header() {
    let mut bytes = stl_binary(&cube(1.0), "solid \u{e9}");
    bytes.extend([b'\n'; 100]);
    assert_eq!(good(&bytes).1.triangles.len(), 12);
    let mut zeros = stl_binary(&cube(1.0), "");
    assert_eq!(good(&zeros).1.triangles.len(), 12);
    zeros.truncate(84 + 50 * 7 + 20);
    let (at, what) = malformed(&zeros);
    assert_eq!(at, Place::Byte(454));
    assert!(
        what.contains("12 triangles") && what.contains("454 bytes"),
        "{what}"
    );
    assert_eq!(
        bad(stl_binary(
            &RawMesh {
                vertices: vec![],
                triangles: vec![],
                ..RawMesh::default()
            },
            "x"
        )),
        ReadError::NoTriangles
    );
}

#[test]
fn ascii_stl_is_read_in_all_its_dialects() {
    let plain = stl_ascii(&cube(1.0), "part");
    let shouted = plain.to_uppercase().replace('\n', "\r\n");
    let mac = plain.replace('\n', "\r");
    let named = plain.replace("solid part", "solid facet of loops, vertex 1 2");
    let several = stl_ascii(&cube(1.0), "a") + "\n" + &stl_ascii(&tetrahedron(), "");
    let mut latin = b"solid caf\xE9\n".to_vec();
    latin.extend(&plain.as_bytes()["solid part\n".len()..]);
    let marked = [b"\xEF\xBB\xBF", plain.as_bytes()].concat();
    let nan = plain.replace("normal 0 0 0", "normal nan -inf 0");
    for text in [shouted, mac, named, nan] {
        assert_eq!(good(text).1.triangles.len(), 12);
    }
    assert_eq!(good(latin).1.triangles.len(), 12);
    assert_eq!(good(marked).1.triangles.len(), 12);
    assert_eq!(good(several).1.triangles.len(), 16);

    assert_eq!(
        bad("solid nothing\nendsolid nothing\n"),
        ReadError::NoTriangles
    );
    let (at, what) = malformed(plain.replacen("vertex 1e0", "vertex one", 1));
    assert!(
        matches!(at, Place::Line(4..=8)) && what.contains("`one`"),
        "{at} {what}"
    );
    let (_, what) = malformed(&plain[..plain.len() / 2]);
    assert!(what.contains("whole"), "{what}");
    let (_, what) = malformed(plain.replace("endsolid part\n", ""));
    assert!(what.contains("12 whole triangles"), "{what}");
}

#[test]
fn obj_faces_are_read_in_all_their_forms() {
    let square = "v 0 0 0 1 0 0\nv 1 0 0 # corner\nv 1 1 0\nv 0 1 0\nv 9 9 9\nvt 0 0\nvn 0 0 1\n";
    for face in [
        "f 1 2 3 4",
        "f 1/1 2/1 3/1 4/1",
        "f 1//1 2//1 3//1 4//1",
        "f 1/1/1 2/1/1 3/1/1 4/1/1 # quad",
        "f -5 -4 -3 -2",
        "g side\nusemtl \u{e9}\ns off\nf 1 2 \\\n3 4",
        "f 1/9223372036854775807/-9223372036854775807 2/0 3 4",
    ] {
        let (format, raw) = good(format!("{square}{face}\n"));
        assert_eq!(format, MeshFormat::Obj);
        assert_eq!(raw.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(raw.vertices.len(), 5);
    }
    assert_eq!(
        good("f 1 2 3\r\nv 0 0 0\r\nv 1 0 0\r\nv 0 1 0")
            .1
            .triangles
            .len(),
        1
    );
    assert_eq!(
        bad(square),
        ReadError::PointCloud {
            format: MeshFormat::Obj,
            points: 5
        }
    );
    for (face, part) in [
        ("f 1 2 6", "vertex 6"),
        ("f 1 2 0", "vertex 0"),
        ("f 1 2 -6", "before the first"),
        ("f 1 2", "2 corners"),
        ("f", "without corners"),
        ("f 1 2 x", "`x`"),
        ("f 1 2 99999999999", "out of range"),
        ("f 1 2 99999999999999999999999", "`99999999999999999999999`"),
        ("f 1 2 -9223372036854775808", "before the first"),
        ("v nan 0 0", "not a finite number"),
        ("v 1e31 0 0", "greatest"),
        ("v 1e999 0 0", "not a finite number"),
        ("v 1 0", "fewer than three"),
        ("v 1 0 0x10", "`0x10`"),
    ] {
        let (at, what) = malformed(format!("{square}{face}\n"));
        assert_eq!(at, Place::Line(8), "{face}");
        assert!(what.contains(part), "{what}");
    }
}

#[test]
fn ply_extras_are_passed_over() {
    let text = "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement camera 2\r\nproperty float f\r\n\
        property list uchar float k\r\nelement nothing 4000000000\r\nelement face 2\r\n\
        property uchar red\r\nproperty list uint16 uint vertex_index\r\n\
        property list uchar float texcoord\r\nelement vertex 5\r\nproperty list char int ring\r\n\
        property float32 z\r\nproperty uchar red\r\nproperty int8 y\r\nproperty double x\r\n\
        end_header\r\n0.5 0\r\n1 2 3 4\r\n7 4 0 1 2 3 2 0 0\r\n7 3 4 3 2 0\r\n\
        0 0 9 0 0\r\n1 5 0 9 0 1\r\n0 0 9 1 1\r\n0 0 9 1 0\r\n0 2.5e0 9 0 0\r\n";
    let (_, raw) = good(text);
    assert_eq!(raw.triangles, [[0, 1, 2], [0, 2, 3], [4, 3, 2]]);
    assert_eq!(raw.vertices[2].coords.as_slice(), [1.0, 1.0, 0.0]);
    assert_eq!(raw.vertices[4].z, 2.5);
}

#[test]
fn ply_counts_and_indices_are_not_believed() {
    let plain = ply_ascii(&cube(1.0));
    for (from, to, part) in [
        ("vertex 8", "vertex 4000000000", "promises 4000000000"),
        ("vertex 8", "vertex 18446744073709551615", "promises"),
        ("vertex 8", "vertex -1", "does not have a valid count"),
        ("face 12", "face 4000000000", "promises"),
        ("3 0 2 3\n", "-3 0 2 3\n", "length -3"),
        ("3 0 2 3\n", "300000000 0 2 3\n", "does not fit"),
        ("3 0 2 3\n", "nan 0 2 3\n", "length NaN"),
        ("3 0 2 3\n", "2 0 2\n", "2 corners"),
        ("3 0 2 3\n", "0\n", "without corners"),
        ("3 0 2 3\n", "3 0 2 8\n", "vertex 8"),
        ("3 0 2 3\n", "3 0 2 -1\n", "-1 is not a vertex index"),
        ("3 0 2 3\n", "3 0 2 1.5\n", "1.5 is not a vertex index"),
        ("3 0 2 3\n", "3 0 2 99999999999\n", "not a vertex index"),
        ("\n0 0 0\n", "\n0 0 inf\n", "not a finite number"),
        ("\n0 0 0\n", "\n0 0 zero\n", "`zero`"),
        ("double x", "double w", "no property x"),
        ("double x", "list uchar double x", "no property x"),
        ("vertex_indices", "corners", "no list"),
        ("format ascii 1.0\n", "", "before any format"),
        ("format ascii", "format morse", "not a known encoding"),
        ("element vertex 8\n", "", "before any element"),
        (
            "property double x",
            "property quad x",
            "not a valid property",
        ),
        ("end_header", "end", "does not belong"),
    ] {
        assert!(plain.contains(from), "{from}");
        let (_, what) = malformed(plain.replacen(from, to, 1));
        assert!(what.contains(part), "{what}");
    }
    let binary = ply_binary(&cube(1.0), true);
    let (at, _) = malformed(&binary[..binary.len() - 1]);
    assert!(matches!(at, Place::Line(_) | Place::Byte(_)));
    let nan = ply_binary(&cube(f64::NAN), false);
    assert_eq!(malformed(nan).0, Place::Vertex(1));
    assert_eq!(malformed("ply\nformat asc").0, Place::Line(2));
    assert_eq!(malformed("ply").0, Place::Line(1));
    assert_eq!(
        bad(
            "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n\
             property float z\nelement face 0\nend_header\n"
        ),
        ReadError::NoTriangles
    );
}

#[test]
fn infinite_and_huge_numbers_are_refused_in_every_format() {
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e31, -1e38] {
        let mut raw = l_shape();
        raw.vertices[4].y = x;
        for bytes in [
            stl_binary(&raw, ""),
            stl_ascii(&raw, "").into(),
            obj(&raw).into(),
            ply_ascii(&raw).into(),
            ply_binary(&raw, false),
        ] {
            let (_, what) = malformed(bytes);
            assert!(what.contains("y is"), "{what}");
        }
    }
}

#[test]
fn limits_hold_whatever_the_format() {
    for (_, bytes) in variants() {
        for limits in [
            Limits {
                triangles: 19,
                ..LIMITS
            },
            Limits {
                triangles: 0,
                ..LIMITS
            },
        ] {
            let error = read(&bytes, None, &limits).unwrap_err();
            let limit = limits.triangles;
            assert_eq!(
                error,
                ReadError::TooLarge {
                    what: "triangles",
                    limit
                }
            );
        }
        let exact = Limits {
            triangles: 20,
            vertices: 12,
            ..Limits::NONE
        };
        assert!(read(&bytes, None, &exact).is_ok());
    }
    let few = Limits {
        vertices: 11,
        ..LIMITS
    };
    let error = read(obj(&l_shape()).as_bytes(), None, &few).unwrap_err();
    assert_eq!(
        error,
        ReadError::TooLarge {
            what: "vertices",
            limit: 11
        }
    );
}

#[test]
fn memory_is_limited_and_reading_can_be_broken_off() {
    let raw = sphere(1.0, 100, 100);
    let of_all = |raw: &RawMesh| -> Vec<Vec<u8>> {
        vec![
            stl_binary(raw, ""),
            stl_ascii(raw, "a").into(),
            obj(raw).into(),
            ply_ascii(raw).into(),
            ply_binary(raw, true),
            off(raw).into(),
            glb(raw),
            gltf(raw).into(),
            threemf(raw),
            dae(raw).into(),
        ]
    };
    for bytes in of_all(&raw) {
        let little = Limits {
            memory: 200_000,
            ..Limits::NONE
        };
        let error = read(&bytes, None, &little).unwrap_err();
        assert!(error.to_string().contains("200000 bytes"), "{error}");
        for stop in 1..5 {
            let checks = AtomicUsize::new(1);
            let ask = || {
                let check = checks.fetch_add(1, Ordering::Relaxed);
                (check == stop).then_some(Interrupted::TimeLimit)
            };
            let stopped = read_interruptible(&bytes, None, &Limits::NONE, Interrupt::new(&ask));
            assert_eq!(stopped, Err(ReadError::Interrupted(Interrupted::TimeLimit)));
        }
    }
}

#[test]
fn what_is_no_mesh_is_said_to_be_none() {
    assert!(not_a_mesh("").contains("empty"));
    let utf16 = |text: &str, mark: bool| -> Vec<u8> {
        let units = mark
            .then_some(0xFEFF)
            .into_iter()
            .chain(text.encode_utf16());
        units.flat_map(u16::to_le_bytes).collect()
    };
    for text in [
        obj(&cube(1.0)),
        stl_ascii(&cube(1.0), "a"),
        ply_ascii(&cube(1.0)),
    ] {
        for mark in [false, true] {
            assert!(not_a_mesh(utf16(&text, mark)).contains("UTF-16"));
        }
    }
    let png = [b"\x89PNG\r\n\x1A\n\0\0\0\rIHDR".as_slice(), &[7; 500]].concat();
    let zeros = vec![0; 100_000];
    let elf = [b"\x7FELF\x02\x01\x01".as_slice(), &[0; 3000]].concat();
    for bytes in [
        &png[..],
        &zeros,
        &elf,
        b"\n\n",
        b"x",
        b"solid",
        b"solid gold is heavy",
        b"<html></html>",
        b"{\"v\": [1, 2, 3]}",
        b"v for victory\nf for failure",
        b"%PDF-1.7",
        b"plywood\n",
        b"# nothing but a comment\n",
        b"o part\ng side\n",
    ] {
        not_a_mesh(bytes);
    }
    // Nor does it become one by its name,
    for bytes in [&png, &elf] {
        let error = read(bytes, Some(MeshFormat::Stl), &LIMITS).unwrap_err();
        assert!(matches!(error, ReadError::NotAMesh { .. }), "{error}");
    }
    // but if the sender declares STL, and it may be the beginning of one, the message says what is missing.
    let odd = [b"\x01\0\x02".as_slice(), &[7; 500]].concat();
    let error = read(&odd, Some(MeshFormat::Stl), &LIMITS).unwrap_err();
    assert!(matches!(error, ReadError::Malformed { .. }), "{error}");
}

#[test]
fn a_file_cut_anywhere_is_refused_or_read_in_part() {
    for (format, bytes) in variants() {
        for end in 0..bytes.len() {
            match read(&bytes[..end], None, &LIMITS) {
                // Text that ends in the middle of its last name or number looks whole.
                Ok((found, _)) => {
                    assert_eq!(found, format);
                    assert!(
                        format == MeshFormat::Obj || end + 12 >= bytes.len(),
                        "{format} at {end}"
                    );
                }
                Err(ReadError::NotAMesh { .. }) => assert!(end < 84, "{format} at {end}"),
                Err(_) => {}
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400), said in 0..4usize) {
        let said = MeshFormat::ALL.get(said).copied();
        if let Ok((_, raw)) = read(&bytes, said, &LIMITS) {
            let _ = Mesh::prepare(raw);
        }
    }

    #[test]
    fn mutated_files_never_panic(
        which in 0..12usize,
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4u8), 1..12),
        said: bool,
    ) {
        let (format, mut bytes) = variants().swap_remove(which);
        for (at, byte, how) in edits {
            let at = at.index(bytes.len().max(1));
            match how {
                _ if at >= bytes.len() => bytes.push(byte),
                0 => bytes[at] = byte,
                1 => bytes[at] ^= 1 << (byte % 8),
                2 => bytes.insert(at, b" \n-/.e9\0"[usize::from(byte % 8)]),
                _ => bytes.truncate(bytes.len() - usize::from(byte % 8).min(bytes.len())),
            }
        }
        if let Ok((_, raw)) = read(&bytes, said.then_some(format), &LIMITS) {
            let _ = Mesh::prepare(raw);
        }
    }
}
