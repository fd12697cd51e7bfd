//! Solids of a few boxes, tori and balls, whose right answers are known by hand.

use nalgebra::{Point3, Vector3};

use super::convex::{Solid, by_lines, contains};
use crate::interrupt::Interrupt;
use crate::mesh::solids::{cuboid, flipped, join, moved, sphere, torus};
use crate::mesh::*;

/// The report of boxes, each given by its corners.
fn of_boxes(boxes: &[[[f64; 3]; 2]]) -> (Mesh, MeshReport) {
    let boxes: Vec<RawMesh> = boxes
        .iter()
        .map(|[low, high]| cuboid(*low, *high))
        .collect();
    let mesh = Mesh::prepare(join(&boxes)).unwrap();
    let report = mesh.report().clone();
    (mesh, report)
}

#[test]
fn a_mallet_of_two_boxes_is_exact_within_its_bound() {
    let (_, report) = of_boxes(&[
        [[-30.0, -15.0, -12.0], [30.0, 15.0, 12.0]],
        [[-6.0, -6.0, -110.0], [6.0, 6.0, 5.0]],
    ]);
    // The head, and of the stick what sticks out.
    let (head, stick) = (60.0 * 30.0 * 24.0, 12.0 * 12.0 * 98.0);
    let volume = report.volume.unwrap();
    assert!((volume / (head + stick) - 1.0).abs() <= report.volume_bound.unwrap());
    assert!(report.volume_bound.unwrap() < 1e-4, "{report:?}");
    let z = stick * -61.0 / (head + stick);
    let off = (report.center_of_mass - Point3::new(0.0, 0.0, z)).norm();
    assert!(off <= report.center_bound.unwrap(), "{off}");
    assert_eq!(
        (report.mass_from, report.overlapping_parts),
        (MassSource::Union, 2)
    );
    assert_eq!((report.body_count, report.components), (1, 2));
    // The upper end of the stick is in the head, and the middle of its sides is not.
    assert_eq!((report.buried_triangles, report.candidates), (2, 22));
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.kind == WarningKind::Overlap)
    );
}

#[test]
fn a_part_within_another_is_matter_or_a_void_as_the_file_winds_it() {
    let case = cuboid([-30.0, -20.0, -10.0], [30.0, 20.0, 10.0]);
    let part = cuboid([5.0, -10.0, -5.0], [15.0, 10.0, 5.0]);
    for parts in [
        [case.clone(), part.clone()],
        [part.clone(), case.clone()],
        [flipped(&case), flipped(&part)],
    ] {
        let report = Mesh::prepare(join(&parts)).unwrap().report().clone();
        assert!((report.volume.unwrap() / 48_000.0 - 1.0).abs() < 1e-12);
        assert!(report.center_of_mass.coords.norm() < 1e-10);
        assert_eq!(
            (report.mass_from, report.buried_triangles),
            (MassSource::Union, 12)
        );
        assert!(report.volume_bound.unwrap() < 1e-12);
    }
    for parts in [
        [case.clone(), flipped(&part)],
        [flipped(&case), part.clone()],
    ] {
        let mesh = Mesh::prepare(join(&parts)).unwrap();
        let report = mesh.report();
        assert!((report.volume.unwrap() / 46_000.0 - 1.0).abs() < 1e-12);
        assert_eq!(
            (report.mass_from, report.enclosed_triangles),
            (MassSource::Solid, 12)
        );
        assert_eq!(
            (report.candidates, mesh.with_enclosed().candidates().len()),
            (12, 24)
        );
        assert!(
            report
                .warnings
                .iter()
                .any(|w| w.kind == WarningKind::Enclosed)
        );
    }
}

#[test]
fn walls_between_blocks_that_touch_are_no_candidates() {
    // Five in a row with whole walls in common, and a small one on the side of a large one.
    let row: Vec<[[f64; 3]; 2]> = (0..5)
        .map(|n| f64::from(n) * 10.0)
        .map(|x| [[x, 0.0, 0.0], [x + 10.0, 20.0, 30.0]])
        .collect();
    let (mesh, report) = of_boxes(&row);
    assert_eq!(
        (report.mass_from, report.body_count),
        (MassSource::Solid, 1)
    );
    assert!((report.volume.unwrap() / 30_000.0 - 1.0).abs() < 1e-12);
    assert_eq!(
        (report.buried_triangles, report.components, report.holes),
        (16, 5, 0)
    );
    assert!(
        report.warnings.iter().all(|w| w.kind != WarningKind::Mass),
        "{:?}",
        report.warnings
    );
    for candidate in mesh.candidates() {
        let inner = (1..5).any(|n| (candidate.position.x - f64::from(n) * 10.0).abs() < 1e-9);
        assert!(!inner, "{candidate:?}");
    }
    let (mesh, report) = of_boxes(&[
        [[0.0, 0.0, 0.0], [40.0, 40.0, 40.0]],
        [[40.0, 10.0, 10.0], [50.0, 20.0, 20.0]],
    ]);
    assert_eq!((report.buried_triangles, report.body_count), (2, 1));
    assert_eq!(report.mass_from, MassSource::Solid);
    let uniform = mesh
        .uniform_candidates(4000, 1, Interrupt::never())
        .unwrap();
    for place in uniform
        .iter()
        .filter(|place| (place.position.x - 40.0).abs() < 1e-9)
    {
        let within = |x: f64| (10.0 + 1e-6..20.0 - 1e-6).contains(&x);
        assert!(
            !(within(place.position.y) && within(place.position.z)),
            "{place:?}"
        );
    }
}

#[test]
fn a_cavity_that_plates_seal_together_is_enclosed() {
    // Six plates that cross at the edges: a box with walls of 2 about a cavity of 16.
    let mut plates: Vec<[[f64; 3]; 2]> = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let (mut low, mut high) = ([-10.0; 3], [10.0; 3]);
            low[axis] = 9.0 * side - 1.0;
            high[axis] = 9.0 * side + 1.0;
            plates.push([low, high]);
        }
    }
    let inner = |mesh: &Mesh| {
        let candidates = mesh
            .uniform_candidates(3000, 1, Interrupt::never())
            .unwrap();
        candidates
            .iter()
            .filter(|c| c.position.coords.amax() < 9.0)
            .count()
    };
    let (mesh, report) = of_boxes(&plates);
    let volume = report.volume.unwrap();
    assert!(
        (volume / (8000.0 - 4096.0) - 1.0).abs() < 1e-4,
        "{report:?}"
    );
    assert_eq!((inner(&mesh), report.enclosed_triangles), (0, 12));
    // Without its lid the same box is open.
    let (mesh, report) = of_boxes(&plates[..5]);
    assert_eq!(report.enclosed_triangles, 0);
    assert!(inner(&mesh) > 500);
}

#[test]
fn bodies_that_do_not_touch_are_counted() {
    let cube = cuboid([0.0; 3], [10.0; 3]);
    let far = moved(&sphere(5.0, 9, 12), [40.0, 0.0, 0.0]);
    // A hook through an eye: their boxes meet, their surfaces do not.
    let eye = torus(10.0, 2.0, 40, 12);
    let mut hook = moved(&eye, [0.0; 3]);
    hook.vertices
        .iter_mut()
        .for_each(|v| *v = Point3::new(v.x + 10.0, v.z, v.y));
    let hook = flipped(&hook);
    for (raw, count) in [
        (join(&[cube.clone(), far.clone()]), 2),
        (
            join(&[cube.clone(), far, moved(&cube, [0.0, 30.0, 0.0])]),
            3,
        ),
        (join(&[eye, hook]), 2),
        (join(&[cube.clone(), moved(&cube, [10.0, 0.0, 0.0])]), 1),
        (join(&[cube.clone(), moved(&cube, [10.0, 10.0, 0.0])]), 1),
        (join(&[cube.clone(), moved(&cube, [10.1, 0.0, 0.0])]), 2),
        (solids::hollow_cube(), 1),
    ] {
        let report = Mesh::prepare(raw).unwrap().report().clone();
        assert_eq!(report.body_count, count);
        assert_eq!(report.bodies.len(), if count == 1 { 0 } else { count });
        let warned = report
            .warnings
            .iter()
            .any(|w| w.kind == WarningKind::SeveralBodies);
        assert_eq!(warned, count > 1);
    }
}

#[test]
fn a_part_that_crosses_itself_is_cut_where_it_does() {
    let raw = solids::spiral(1.2);
    let quad = |n: u32| {
        let at = |i: u32| raw.vertices[(4 * n + i) as usize];
        let outline = [at(0), at(1), at(5), at(4)];
        let mut planes = vec![(Vector3::z(), 10.0), (-Vector3::z(), 0.0)];
        for i in 0..4 {
            let outward = (outline[(i + 1) % 4] - outline[i])
                .cross(&Vector3::z())
                .normalize();
            planes.push((outward, outward.dot(&outline[i].coords)));
        }
        planes
    };
    let solid = [Solid {
        convex: (0..60).map(quad).collect(),
        raw: raw.clone(),
    }];
    let mesh = Mesh::prepare(raw.clone()).unwrap();
    let report = mesh.report();
    assert_eq!(
        (report.mass_from, report.overlapping_parts),
        (MassSource::Union, 1)
    );
    let (volume, center) = by_lines(&solid, &report.bounds, 600);
    assert!(
        (report.volume.unwrap() / volume - 1.0).abs() < 1e-3,
        "{report:?} for {volume}"
    );
    assert!((report.center_of_mass - center).norm() < 1e-3 * report.bounding_radius);
    for candidate in mesh
        .uniform_candidates(2000, 1, Interrupt::never())
        .unwrap()
    {
        let step = candidate.normal.into_inner() * 0.01;
        assert!(
            !contains(&solid, &(candidate.position - step)),
            "{candidate:?}"
        );
        assert!(
            contains(&solid, &(candidate.position + step)),
            "{candidate:?}"
        );
    }
}

#[test]
fn loose_faces_face_outward_or_are_counted() {
    // The six sides of a box, each a little smaller than the next would need to meet it, every other one inside out.
    let whole = cuboid([0.0; 3], [60.0, 40.0, 20.0]);
    let mut loose = whole.clone();
    (loose.vertices, loose.triangles) = (Vec::new(), Vec::new());
    for side in 0..6 {
        let pair = &whole.triangles[2 * side..2 * side + 2];
        let corners = [pair[0][0], pair[0][1], pair[0][2], pair[1][2]];
        let corners = corners.map(|n| whole.vertices[n as usize]);
        let middle = Point3::from(corners.iter().map(|c| c.coords).sum::<Vector3<f64>>() / 4.0);
        let first = loose.vertices.len() as u32;
        loose
            .vertices
            .extend(corners.map(|corner| middle + (corner - middle) * 0.999));
        let quads = [[first, first + 1, first + 2], [first, first + 2, first + 3]];
        let turned = quads.map(|[a, b, c]| if side % 2 == 0 { [a, b, c] } else { [a, c, b] });
        loose.triangles.extend(turned);
    }
    let mesh = Mesh::prepare(loose.clone()).unwrap();
    let middle = Point3::new(30.0, 20.0, 10.0);
    for candidate in mesh.candidates() {
        assert!(
            candidate.normal.dot(&(middle - candidate.position)) > 0.0,
            "{candidate:?}"
        );
    }
    assert_eq!(
        (mesh.report().unverified_normals, mesh.report().body_count),
        (0, 1)
    );
    // With four sides missing nothing says where the inside is.
    loose.triangles.drain(6..);
    loose.triangles.drain(2..4);
    let report = Mesh::prepare(loose).unwrap().report().clone();
    assert_eq!(report.unverified_normals, 4);
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.kind == WarningKind::UnverifiedNormals)
    );
}

#[test]
fn a_degenerate_triangle_is_no_body() {
    let mut raw = cuboid([0.0; 3], [1.0; 3]);
    let first = raw.vertices.len() as u32;
    raw.vertices
        .extend([2.0, 2.5, 3.0].map(|x| Point3::new(x, 5.0, 5.0)));
    raw.triangles.push([first, first + 1, first + 2]);
    let mesh = Mesh::prepare(raw).unwrap();
    let report = mesh.report();
    assert_eq!((report.body_count, report.degenerate_triangles), (1, 1));
}
