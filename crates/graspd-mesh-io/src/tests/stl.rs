//! Binary STL files that are longer than the count of their header says.

use graspd_core::mesh::WarningKind;

use super::*;

fn details(raw: &RawMesh) -> Vec<&str> {
    let of = |warning: &graspd_core::mesh::MeshWarning| warning.kind == WarningKind::File;
    let found = raw.warnings.iter().filter(|warning| of(warning));
    found.map(|warning| warning.detail.as_str()).collect()
}

#[test]
fn all_binary_solids_are_read() {
    // The first solid is large, and what follows it is as short as what passes for a trailer.
    let parts = [
        sphere(1.0, 20, 30),
        moved(&cube(20.0), [50.0, 0.0, 0.0]),
        tetrahedron(),
    ];
    let file = parts
        .each_ref()
        .map(|part| stl_binary(part, "part"))
        .concat();
    let (format, raw) = good(&file);
    assert_eq!(format, MeshFormat::Stl);
    assert_eq!(raw.triangles, soup(&join(&parts)).triangles);
    let exact = soup(&join(&parts));
    let far = raw
        .vertices
        .iter()
        .zip(&exact.vertices)
        .map(|(a, b)| (a - b).norm());
    assert!(far.fold(0.0, f64::max) < 1e-6);
    assert!(details(&raw).is_empty());
}

#[test]
fn a_solid_that_is_cut_short_is_refused() {
    let first = stl_binary(&cube(1.0), "");
    for second in [
        stl_binary(&cube(2.0), "lid"),
        stl_binary(&sphere(1.0, 20, 30), ""),
    ] {
        let file = [&first[..], &second[..second.len() - 30]].concat();
        let (at, what) = malformed(&file);
        assert_eq!(at, Place::Byte(first.len()));
        assert!(what.contains("one more solid"), "{what}");
    }
}

#[test]
fn bytes_behind_the_solid_are_counted() {
    for trailer in [
        vec![0; 1],
        vec![b'\n'; 100],
        vec![0; 200],
        b"made by a program".repeat(50),
    ] {
        let file = [stl_binary(&cube(1.0), ""), trailer.clone()].concat();
        let raw = good(&file).1;
        assert_eq!(raw.triangles.len(), 12);
        let [detail] = details(&raw)[..] else {
            panic!("{:?}", raw.warnings);
        };
        assert!(
            detail.starts_with(&format!("{} bytes behind", trailer.len())),
            "{detail}"
        );
    }
}

#[test]
fn attributes_may_announce_bytes_or_be_a_colour() {
    let plain = stl_binary(&cube(1.0), "");
    let (header, records) = plain.split_at(84);
    let with = |attribute: u16, payload: usize| {
        let record = |record: &[u8]| {
            [
                &record[..48],
                &attribute.to_le_bytes(),
                &vec![7; payload][..],
            ]
            .concat()
        };
        let records: Vec<u8> = records.chunks(50).flat_map(record).collect();
        [header, &records].concat()
    };
    for payload in [1, 6, 300] {
        let raw = good(with(payload as u16, payload)).1;
        assert_eq!(soup(&raw), soup(&cube(1.0)));
        let [detail] = details(&raw)[..] else {
            panic!("{:?}", raw.warnings);
        };
        assert!(
            detail.starts_with(&format!("{} bytes of attributes", 12 * payload)),
            "{detail}"
        );
    }
    let coloured = good(with(0x7C1F, 0)).1;
    assert_eq!(soup(&coloured), soup(&cube(1.0)));
    assert!(details(&coloured).is_empty());
}
