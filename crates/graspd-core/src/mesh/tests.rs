//! What preparation makes of bodies that are whole, turned, moved, hollow, open or none.

use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;

use super::solids::*;
use super::*;

fn prepared(raw: RawMesh) -> Mesh {
    Mesh::prepare(raw).unwrap()
}

fn assert_solid(raw: RawMesh, volume: f64, center: [f64; 3]) -> Mesh {
    let mesh = prepared(raw);
    let report = mesh.report();
    assert_eq!(report.mass_from, MassSource::Solid);
    assert!(report.watertight, "{report:?}");
    let found = report.volume.unwrap();
    assert!((found / volume - 1.0).abs() < 1e-12, "{found} for {volume}");
    let off = (report.center_of_mass - Point3::from(center)).norm();
    assert!(off < 1e-12, "centre off by {off}");
    mesh
}

fn all_inward(mesh: &Mesh, inside: impl Fn(&Point3<f64>) -> bool) {
    for candidate in mesh.candidates() {
        let step = candidate.normal.into_inner() * 1e-4;
        assert!(inside(&(candidate.position + step)), "{candidate:?}");
        assert!(!inside(&(candidate.position - step)), "{candidate:?}");
    }
}

#[test]
fn known_solids_weigh_what_they_should() {
    let mesh = assert_solid(cube(2.0), 8.0, [1.0; 3]);
    let report = mesh.report();
    assert_eq!((report.vertices, report.triangles), (8, 12));
    assert_eq!((report.components, report.candidates), (1, 12));
    assert_eq!((report.area, report.area_ratio), (24.0, 1.0));
    assert!((report.bounding_radius - 3f64.sqrt()).abs() < 1e-15);
    assert_solid(tetrahedron(), 1.0 / 6.0, [0.25; 3]);
    assert_solid(l_shape(), 3.0, [5.0 / 6.0, 5.0 / 6.0, 0.5]);

    let report = prepared(sphere(2.0, 100, 200)).report().clone();
    assert!((report.volume.unwrap() / (32.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3);
    let ring = prepared(torus(3.0, 1.0, 200, 100));
    let exact = 6.0 * std::f64::consts::PI.powi(2);
    assert!((ring.report().volume.unwrap() / exact - 1.0).abs() < 2e-3);
    for candidate in ring.candidates() {
        let p = candidate.position;
        let core = Point3::new(p.x, p.y, 0.0) * (3.0 / p.x.hypot(p.y));
        assert!((core - p).dot(&candidate.normal) > 0.9);
    }
}

#[test]
fn whatever_the_winding_candidates_point_into_the_body() {
    let in_l = |p: &Point3<f64>| {
        (0.0..1.0).contains(&p.z)
            && p.x > 0.0
            && p.y > 0.0
            && (p.x < 1.0 && p.y < 2.0 || p.x < 2.0 && p.y < 1.0)
    };
    let raw = l_shape();
    let count = raw.triangles.len();
    for (turned, raw) in [
        (0, raw.clone()),
        (count, flipped(&raw)),
        (1, flipped_where(&raw, |n| n == 7)),
        (6, flipped_where(&raw, |n| n % 10 < 3)),
        (3, soup(&flipped_where(&raw, |n| n < 3))),
    ] {
        let mesh = assert_solid(raw, 3.0, [5.0 / 6.0, 5.0 / 6.0, 0.5]);
        assert_eq!(mesh.report().flipped_triangles, turned);
        all_inward(&mesh, in_l);
    }
}

#[test]
fn a_hollow_body_stays_hollow_if_its_shells_are_wound_apart() {
    let shell = cuboid([-1.5; 3], [1.5; 3]);
    let cavity = cuboid([-0.5; 3], [0.5; 3]);
    let solid = |p: &Point3<f64>| (0.5..1.5).contains(&p.coords.amax());
    assert_eq!(prepared(hollow_cube()).report().flipped_triangles, 0);
    for (outer, inner) in [
        (shell.clone(), flipped(&cavity)),
        (flipped(&shell), cavity.clone()),
        // A winding that contradicts itself says nothing, and depth decides.
        (shell.clone(), flipped_where(&cavity, |n| n % 3 == 0)),
        (flipped_where(&shell, |n| n % 4 == 0), cavity.clone()),
    ] {
        for parts in [
            [outer.clone(), inner.clone()],
            [inner.clone(), outer.clone()],
        ] {
            let mesh = assert_solid(join(&parts), 26.0, [0.0; 3]);
            assert_eq!(mesh.report().components, 2);
            assert_eq!(mesh.candidates().len(), 12);
            all_inward(&mesh.with_enclosed(), solid);
        }
    }
    let core = cuboid([-0.2; 3], [0.2; 3]);
    let raw = join(&[core, hollow_cube()]);
    assert_solid(raw, 26.0 + 0.4f64.powi(3), [0.0; 3]);
}

#[test]
fn solids_side_by_side_are_not_cavities() {
    let apart = [moved(&cube(1.0), [3.0, 0.0, 0.0]), flipped(&cube(1.0))];
    assert_solid(join(&apart), 2.0, [2.0, 0.5, 0.5]);

    // Along an edge and face to face: closed, though more than two triangles meet at edges.
    for by in [[1.0, 1.0, 0.0], [1.0, 0.0, 0.0]] {
        let raw = join(&[cube(1.0), moved(&cube(1.0), by)]);
        let report = prepared(raw).report().clone();
        assert!(report.non_manifold_edges > 0 && !report.watertight);
        if by[1] == 1.0 {
            assert!((report.volume.unwrap() - 2.0).abs() < 1e-12, "{report:?}");
        }
    }
}

#[test]
fn a_body_with_a_small_hole_is_weighed_as_if_it_were_closed() {
    let whole = prepared(sphere(1.0, 20, 40)).report().clone();
    let mut raw = sphere(1.0, 20, 40);
    raw.triangles.pop();
    for raw in [raw.clone(), flipped(&raw)] {
        let mesh = prepared(raw);
        let report = mesh.report();
        assert_eq!((report.mass_from, report.holes), (MassSource::Capped, 1));
        assert!(!report.watertight);
        assert_eq!((report.border_edges, report.non_manifold_edges), (3, 0));
        // The cap of a triangle is that triangle, cut into three.
        let volume = report.volume.unwrap() / whole.volume.unwrap();
        assert!((volume - 1.0).abs() < 1e-12 && report.center_of_mass.coords.norm() < 1e-12);
        assert!(report.volume_error.unwrap() < 1e-12);
        let inward = |c: &Candidate| c.position.coords.dot(&c.normal) < -0.9;
        assert!(mesh.candidates().iter().all(inward));
    }
    // A fin on a closed body weighs nothing.
    let mut raw = cube(1.0);
    raw.vertices.push(Point3::new(1.5, 1.5, 1.5));
    raw.triangles.push([6, 7, 8]);
    let report = prepared(raw).report().clone();
    assert_eq!((report.border_edges, report.non_manifold_edges), (2, 1));
    assert_eq!(
        (report.components, report.mass_from),
        (2, MassSource::Capped)
    );
    assert!((report.volume.unwrap() - 1.0).abs() < 1e-12);
    assert!((report.center_of_mass - Point3::from([0.5; 3])).norm() < 1e-12);
}

#[test]
fn an_open_body_is_weighed_as_a_shell() {
    // Half a ball without its floor: as good a bowl as a solid.
    let mut raw = sphere(1.0, 20, 40);
    let above = |&index: &u32| raw.vertices[index as usize].z > -1e-9;
    raw.triangles.retain(|corners| corners.iter().all(above));
    let report = prepared(raw).report().clone();
    assert_eq!((report.mass_from, report.holes), (MassSource::Surface, 1));
    assert_eq!((report.volume, report.volume_error), (None, None));
    assert!((report.center_of_mass.z - 0.5).abs() < 0.01, "{report:?}");
}

#[test]
fn a_surface_with_two_sides_is_one_body() {
    for raw in [l_shape(), torus(3.0, 1.0, 12, 8)] {
        let plain = prepared(raw.clone()).report().clone();
        let mesh = prepared(join(&[raw.clone(), flipped(&raw)]));
        let report = mesh.report();
        assert_eq!(report.duplicate_triangles, raw.triangles.len());
        assert_eq!(
            (report.volume, report.triangles),
            (plain.volume, plain.triangles)
        );
        assert!(
            report.watertight
                && mesh
                    .source()
                    .iter()
                    .all(|&n| (n as usize) < raw.triangles.len())
        );
    }
}

#[test]
fn a_klein_bottle_is_no_solid() {
    let (n, m) = (12, 12);
    let at = |i: u32, j: u32| match i {
        _ if i == n => (m - j % m) % m,
        _ => i * m + j % m,
    };
    let mut raw = torus(3.0, 1.0, n, m);
    raw.triangles.clear();
    for i in 0..n {
        for j in 0..m {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            raw.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let report = prepared(raw).report().clone();
    assert_eq!((report.border_edges, report.volume), (0, None));
    assert!(report.non_manifold_edges > 0 && !report.watertight);
}

#[test]
fn far_from_the_origin_nothing_is_lost() {
    for (raw, volume) in [(l_shape(), 3.0), (hollow_cube(), 26.0)] {
        let near = prepared(raw.clone());
        let far = prepared(moved(&raw, [1e6, -1e6, 1e6]));
        let found = far.report().volume.unwrap();
        assert!((found / volume - 1.0).abs() < 1e-9, "{found}");
        let shift = far.report().center_of_mass - near.report().center_of_mass;
        assert!((shift - Vector3::new(1e6, -1e6, 1e6)).norm() < 1e-9);
        assert!((far.report().bounding_radius - near.report().bounding_radius).abs() < 1e-9);
        assert_eq!(far.candidates().len(), near.candidates().len());
    }
}

#[test]
fn extreme_sizes_neither_overflow_nor_vanish() {
    for scale in [1e-30, 1e-9, 1e9, 0.9e30] {
        let mut raw = l_shape();
        raw.vertices.iter_mut().for_each(|v| *v *= scale / 2.0);
        let mesh = prepared(raw);
        let volume = mesh.report().volume.unwrap() / (3.0 * (scale / 2.0).powi(3));
        assert!((volume - 1.0).abs() < 1e-12, "{scale:e}: {volume}");
        assert!(mesh.report().area.is_finite() && mesh.report().bounding_radius > 0.0);
    }
}

#[test]
fn slivers_close_the_surface_but_are_no_candidates() {
    // A vertex on an edge: the neighbour is closed by a triangle of zero area.
    let mut raw = cube(1.0);
    raw.vertices.push(Point3::new(0.5, 0.0, 0.0));
    let split = raw.triangles.iter().position(|t| t == &[0, 1, 5]).unwrap();
    raw.triangles[split] = [0, 8, 5];
    raw.triangles.extend([[8, 1, 5], [0, 1, 8], [3, 3, 5]]);
    let mesh = assert_solid(raw, 1.0, [0.5; 3]);
    let report = mesh.report();
    assert_eq!((report.triangles_read, report.triangles), (15, 14));
    assert_eq!((report.degenerate_triangles, report.candidates), (2, 13));
    assert_eq!(mesh.candidates().len(), 13);
    assert_eq!(mesh.source().last(), Some(&13));
    assert!(mesh.candidates().iter().all(|c| c.triangle != 13));
}

#[test]
fn what_is_no_body_is_refused_with_its_reason() {
    let with = |vertices: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>| RawMesh {
        vertices: vertices.into_iter().map(Point3::from).collect(),
        triangles,
        ..RawMesh::default()
    };
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]];
    let refused = |raw| Mesh::prepare(raw).unwrap_err();
    assert_eq!(
        refused(with(corners.clone(), vec![])),
        PrepareError::NoTriangles
    );
    assert_eq!(
        refused(with(corners.clone(), vec![[0, 1, 3], [1, 1, 2]])),
        PrepareError::AllDegenerate(2)
    );
    assert_eq!(
        refused(with(vec![[7.0; 3]], vec![[0, 0, 0]])),
        PrepareError::AllDegenerate(1)
    );
    assert_eq!(
        refused(with(corners.clone(), vec![[0, 1, 4]])),
        PrepareError::BadIndex(0)
    );
    let mut bad = corners.clone();
    bad[2][1] = f64::NAN;
    assert_eq!(
        refused(with(bad, vec![[0, 1, 2]])),
        PrepareError::BadVertex(2)
    );

    // A sheet, single or double, in an oblique plane.
    let turn = Rotation3::from_euler_angles(0.3, 1.1, 2.0);
    let mut sheet = with(corners, vec![[0, 1, 2], [1, 3, 2]]);
    sheet
        .vertices
        .iter_mut()
        .for_each(|v| *v = turn * *v + Vector3::new(5.0, 1.0, 2.0));
    let double = join(&[sheet.clone(), flipped(&sheet)]);
    for raw in [sheet, double] {
        assert!(matches!(refused(raw), PrepareError::Flat(_)));
    }
}

#[test]
fn the_same_input_gives_the_same_bits() {
    let raw = soup(&flipped_where(&torus(3.0, 1.0, 40, 20), |n| n % 3 == 0));
    let (a, b) = (prepared(raw.clone()), prepared(raw));
    assert_eq!(a.report(), b.report());
    assert_eq!((a.vertices(), a.triangles()), (b.vertices(), b.triangles()));
}

/// A body with a corner of each kind, by number.
fn body(kind: u8) -> RawMesh {
    match kind % 5 {
        0 => l_shape(),
        1 => hollow_cube(),
        2 => torus(3.0, 1.0, 12, 8),
        3 => tetrahedron(),
        _ => sphere(1.0, 8, 12),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn order_rotation_and_winding_change_no_mass(
        kind: u8,
        seed in prop::collection::vec(any::<u32>(), 200),
        angles in prop::array::uniform3(-3.0..3.0f64),
        by in prop::array::uniform3(-10.0..10.0f64),
    ) {
        let raw = body(kind);
        let plain = prepared(raw.clone());
        let turn = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let mut other = flipped_where(&raw, |n| seed[n % 200] % 10 < 3);
        let mut order: Vec<usize> = (0..other.triangles.len()).collect();
        order.sort_by_key(|&n| seed[n % 200].rotate_left(n as u32 / 200));
        other.triangles = order.iter().map(|&n| {
            let mut triangle = other.triangles[n];
            triangle.rotate_left(seed[n % 200] as usize % 3);
            triangle
        }).collect();
        other.vertices.iter_mut().for_each(|v| *v = turn * *v + Vector3::from(by));
        let other = prepared(soup(&other));

        let (a, b) = (plain.report(), other.report());
        prop_assert!((a.volume.unwrap() / b.volume.unwrap() - 1.0).abs() < 1e-9);
        prop_assert!((a.bounding_radius / b.bounding_radius - 1.0).abs() < 1e-9);
        let center = turn * a.center_of_mass + Vector3::from(by);
        prop_assert!((center - b.center_of_mass).norm() < 1e-9);
        prop_assert_eq!(
            (a.components, a.candidates, a.watertight),
            (b.components, b.candidates, b.watertight)
        );
        for candidate in other.candidates() {
            let same = plain.candidates()[order[candidate.triangle as usize]];
            let normal = turn * same.normal.into_inner();
            prop_assert!((normal - candidate.normal.into_inner()).norm() < 1e-9);
        }
    }

    #[test]
    fn any_triangles_are_prepared_or_refused(
        grid in prop::collection::vec(prop::array::uniform3(-2i8..3), 3..20),
        triangles in prop::collection::vec(prop::array::uniform3(0u32..21), 0..60),
        scale in prop::sample::select(vec![1.0, 1e-38, 1e-20, 1e-7, 1e29]),
    ) {
        let raw = RawMesh {
            vertices: grid.iter().map(|p| Point3::from(p.map(|x| f64::from(x) * scale))).collect(),
            triangles,
..RawMesh::default()
};
        if let Ok(mesh) = Mesh::prepare(raw.clone()) {
            let report = mesh.report();
            prop_assert_eq!(mesh.candidates().len(), report.candidates);
            prop_assert!(report.candidates > 0);
            prop_assert!(report.bounding_radius > 0.0 && report.bounding_radius.is_finite());
            prop_assert!(report.center_of_mass.iter().all(|x| x.is_finite()));
            prop_assert!(report.area_ratio >= 1.0);
            prop_assert!(report.volume.is_none_or(|volume| volume > 0.0));
            prop_assert_eq!(mesh.source().len(), report.triangles);
            for candidate in mesh.candidates() {
                prop_assert!((candidate.normal.norm() - 1.0).abs() < 1e-12);
            }
        }
    }
}
