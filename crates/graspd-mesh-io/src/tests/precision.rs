//! Bodies that are small beside their distance from the origin.

use graspd_core::mesh::WarningKind;

use super::*;

fn warned(bytes: Vec<u8>) -> Option<String> {
    let (_, raw) = good(bytes);
    let found = raw.warnings.into_iter();
    let mut found = found.filter(|warning| warning.kind == WarningKind::Precision);
    found.next().map(|warning| warning.detail)
}

#[test]
fn the_step_of_single_precision_is_compared_with_the_size() {
    let ball = sphere(30.0, 8, 12);
    let far = |x: f64| moved(&ball, [x, -5.0, 0.0]);
    // Single precision has steps of 2^-11 from 4096 to 8192, of 2^-3 from 2^20 to 2^21 and of 1 from 2^23 to 2^24.
    for (x, step) in [
        (0.0, None),
        (5e3, None),
        (1.5e6, Some("1.250e-1")),
        (1e7, Some("1.000e0")),
    ] {
        for bytes in [stl_binary(&far(x), ""), glb(&far(x))] {
            let found = warned(bytes);
            assert_eq!(found.is_some(), step.is_some(), "{x}: {found:?}");
            let names = |step| {
                found
                    .iter()
                    .any(|text| text.contains(&format!("steps of {step}")))
            };
            assert!(step.is_none_or(names), "{found:?}");
        }
        // These have all digits.
        for bytes in [
            obj(&far(x)).into(),
            ply_binary(&far(x), false),
            stl_ascii(&far(x), "").into(),
        ] {
            assert_eq!(warned(bytes), None);
        }
    }
    let doubles = ply_binary(&far(1e7), false);
    let header = ply_header(&ball, "binary_little_endian").len();
    let singles = doubles[header..header + 24 * ball.vertices.len()]
        .as_chunks()
        .0;
    let singles = singles
        .iter()
        .flat_map(|x| (f64::from_le_bytes(*x) as f32).to_le_bytes());
    let head = ply_header(&ball, "binary_little_endian").replace("double", "float");
    let faces = &doubles[header + 24 * ball.vertices.len()..];
    let file = [head.into_bytes(), singles.collect(), faces.to_vec()].concat();
    assert!(warned(file).unwrap().contains("steps of 1.000e0"));
}

#[test]
fn triangles_that_collapsed_are_counted() {
    let far = moved(&sphere(30.0, 12, 16), [1e8; 3]);
    let raw = good(stl_binary(&far, "")).1;
    let mesh = Mesh::prepare(raw).unwrap();
    let report = mesh.report();
    assert!(report.degenerate_triangles > 0);
    let kinds: Vec<WarningKind> = report.warnings.iter().map(|warning| warning.kind).collect();
    assert!(
        kinds.contains(&WarningKind::Precision) && kinds.contains(&WarningKind::Degenerate),
        "{kinds:?}"
    );
}
