//! Everyday things that people model as solids which cross, touch or nest, each compared with an integral over lines.
//!
//! Every thing is a union of convex polyhedra, which half-spaces describe without triangles. Along a line through it the
//! half-spaces of each polyhedron leave an interval; the length of the union of the intervals, integrated over a grid of
//! lines, is the volume. Nothing of this uses winding numbers, cuts or fluxes.
//!
//! The table has what the same things with seed 1 came to when parts were not compared, with 2,000 uniform candidates
//! each: how many of them point out of the body ("pull"), how many lie in matter ("buried"), and how far volume and
//! centre of mass were off, in percent of the volume and of the bounding radius. Now no candidate pulls or is buried, the
//! volume is right within the 0.4 % of the integral over lines, and the centre within 0.1 % of the radius.
//!
//! | thing | pull | buried | volume, % | centre, % |
//! |---|---|---|---|---|
//! | mug | 0 | 123 | 1.33 | 0.517 |
//! | mallet | 0 | 187 | 4.43 | 0.270 |
//! | hammer | 0 | 153 | 4.63 | 1.037 |
//! | dumbbell | 0 | 320 | 7.99 | 0.211 |
//! | cross | 0 | 203 | 11.59 | 0.069 |
//! | kettle | 91 | 235 | -2.59 | 2.314 |
//! | spoon | 0 | 137 | 2.39 | 0.047 |
//! | table | 0 | 61 | 1.10 | 0.080 |
//! | snowman | 0 | 291 | 4.51 | 1.327 |
//! | pan | 0 | 57 | 1.03 | 0.299 |
//! | bracket | 0 | 68 | 4.64 | 1.811 |
//! | bottle | 0 | 376 | 7.05 | 3.613 |
//! | fan | 456 | 219 | -98.52 | 16.909 |
//! | screwdriver | 0 | 79 | 0.97 | 0.369 |
//! | key | 0 | 123 | 3.40 | 0.810 |
//! | bench of blocks | 0 | 289 | 0.00 | 0.000 |
//! | core in a case | 0 | 374 | -11.81 | 0.488 |
//! | chain of two links | 0 | 373 | 16.04 | 3.359 |

use nalgebra::{Point3, Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::solids::{cuboid, flipped, join, moved, sphere, torus};
use super::*;
use crate::interrupt::Interrupt;

/// A body of revolution about the z axis with a convex outline of radii and heights, from the bottom up.
fn turned(outline: &[[f64; 2]], segments: u32) -> RawMesh {
    let mut raw = cuboid([0.0; 3], [1.0; 3]);
    raw.vertices.clear();
    raw.triangles.clear();
    let (bottom, top) = (outline[0][1], outline[outline.len() - 1][1]);
    raw.vertices
        .extend([Point3::new(0.0, 0.0, bottom), Point3::new(0.0, 0.0, top)]);
    for [radius, height] in outline {
        for n in 0..segments {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(n) / f64::from(segments)).sin_cos();
            raw.vertices
                .push(Point3::new(radius * cos, radius * sin, *height));
        }
    }
    let at = |ring: usize, n: u32| 2 + ring as u32 * segments + n % segments;
    let last = outline.len() - 1;
    for n in 0..segments {
        raw.triangles.extend([
            [0, at(0, n + 1), at(0, n)],
            [1, at(last, n), at(last, n + 1)],
        ]);
        for ring in 0..last {
            let (a, b) = (at(ring, n), at(ring, n + 1));
            let (c, d) = (at(ring + 1, n + 1), at(ring + 1, n));
            raw.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    raw
}

fn cylinder(radius: f64, low: f64, high: f64) -> RawMesh {
    turned(&[[radius, low], [radius, high]], 40)
}

/// A solid and the convex bodies that make it up.
#[derive(Clone)]
struct Solid {
    raw: RawMesh,
    convex: Vec<Convex>,
}

/// Half-spaces by outward normal and offset.
type Convex = Vec<(Vector3<f64>, f64)>;

fn half_spaces(raw: &RawMesh) -> Convex {
    let planes = raw.triangles.iter().map(|&indices| {
        let corners = triangle::corners(&raw.vertices, indices);
        let normal = triangle::normal(&corners).normalize();
        (normal, normal.dot(&corners[0].coords))
    });
    planes.collect()
}

fn convex(raw: RawMesh) -> Solid {
    Solid {
        convex: vec![half_spaces(&raw)],
        raw,
    }
}

/// A torus, and the wedges between two neighbouring sections, each of which is convex.
fn ring(major: f64, minor: f64) -> Solid {
    let (around, across) = (48, 20);
    let raw = torus(major, minor, around, across);
    let wedge = |i: u32| {
        let mut planes = Convex::new();
        for j in 0..across {
            let first = (i * across + j) as usize * 2;
            let corners = triangle::corners(&raw.vertices, raw.triangles[first]);
            let normal = triangle::normal(&corners).normalize();
            planes.push((normal, normal.dot(&corners[0].coords)));
        }
        for (at, side) in [(i, -1.0), (i + 1, 1.0)] {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(at) / f64::from(around)).sin_cos();
            planes.push((Vector3::new(-sin, cos, 0.0) * side, 0.0));
        }
        planes
    };
    let convex = (0..around).map(wedge).collect();
    Solid { raw, convex }
}

impl Solid {
    fn placed(mut self, turn: Rotation3<f64>, by: [f64; 3]) -> Self {
        let by = Vector3::from(by);
        self.raw
            .vertices
            .iter_mut()
            .for_each(|v| *v = turn * *v + by);
        for (normal, offset) in self.convex.iter_mut().flatten() {
            *normal = turn * *normal;
            *offset += normal.dot(&by);
        }
        self
    }

    fn at(self, by: [f64; 3]) -> Self {
        self.placed(Rotation3::identity(), by)
    }
}

fn block(low: [f64; 3], high: [f64; 3]) -> Solid {
    convex(cuboid(low, high))
}

fn about(axis: Vector3<f64>, degrees: f64) -> Rotation3<f64> {
    Rotation3::new(axis * degrees.to_radians())
}

/// The things, in millimetres; sizes vary with the seed by a tenth.
fn things(seed: u64) -> Vec<(&'static str, Vec<Solid>)> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut s = || 0.9 + 0.2 * (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let (x, y) = (Vector3::x(), Vector3::y());
    let rod = |radius: f64, low: f64, high: f64| convex(cylinder(radius, low, high));
    let ball = |radius: f64| convex(sphere(radius, 16, 24));
    let mut all = vec![
        (
            "mug",
            vec![
                rod(40.0 * s(), 0.0, 95.0),
                ring(25.0 * s(), 6.0).placed(about(x, 90.0), [45.0, 0.0, 48.0]),
            ],
        ),
        (
            "mallet",
            vec![
                block([-40.0 * s(), -18.0, -20.0], [40.0, 18.0, 20.0]),
                block([-7.0, -7.0, -120.0 * s()], [7.0, 7.0, 10.0]),
            ],
        ),
        (
            "hammer",
            vec![
                rod(14.0 * s(), -45.0, 45.0).placed(about(y, 90.0), [0.0; 3]),
                rod(9.0, -180.0 * s(), 5.0),
            ],
        ),
        (
            "dumbbell",
            vec![
                rod(11.0, -70.0, 70.0),
                ball(33.0 * s()).at([0.0, 0.0, 70.0]),
                ball(33.0 * s()).at([0.0, 0.0, -70.0]),
            ],
        ),
        (
            "cross",
            vec![
                block([-50.0 * s(), -9.0, -9.0], [50.0, 9.0, 9.0]),
                block([-8.0, -60.0 * s(), -8.0], [8.0, 60.0, 8.0]),
                block([-7.0, -7.0, -40.0 * s()], [7.0, 7.0, 40.0]),
            ],
        ),
        (
            "kettle",
            vec![
                ball(60.0 * s()),
                convex(turned(&[[14.0, 0.0], [8.0, 70.0]], 24))
                    .placed(about(y, 60.0), [35.0, 0.0, 10.0]),
                ring(45.0 * s(), 5.0).placed(about(x, 90.0), [0.0, 0.0, 45.0]),
            ],
        ),
        (
            "spoon",
            vec![
                ball(22.0 * s()),
                block([-4.0, -3.0, 0.0], [4.0, 3.0, 150.0 * s()]),
            ],
        ),
        (
            "table",
            vec![
                block([-60.0 * s(), -40.0, 0.0], [60.0, 40.0, 8.0]),
                block([-55.0, -35.0, -70.0], [-47.0, -27.0, 4.0]),
                block([40.0, -35.0, -70.0], [48.0, -27.0, 4.0]),
                block([40.0, 27.0, -70.0], [48.0, 35.0, 4.0]),
                block([-55.0, 27.0, -70.0], [-47.0, 35.0, 4.0]),
            ],
        ),
        (
            "snowman",
            vec![
                ball(40.0 * s()),
                ball(30.0).at([0.0, 0.0, 55.0]),
                ball(20.0 * s()).at([0.0, 0.0, 92.0]),
            ],
        ),
        (
            "pan",
            vec![
                rod(90.0 * s(), 0.0, 30.0),
                rod(10.0, 0.0, 160.0).placed(about(y, 80.0), [60.0, 0.0, 15.0]),
            ],
        ),
        (
            "bracket",
            vec![
                block([0.0, 0.0, 0.0], [60.0 * s(), 30.0, 5.0]),
                block([0.0, 0.0, 0.0], [5.0, 30.0, 50.0 * s()]),
            ],
        ),
        (
            "bottle",
            vec![
                rod(30.0 * s(), 0.0, 120.0),
                convex(turned(&[[29.0, 110.0], [11.0, 150.0]], 40)),
                rod(11.0, 140.0, 180.0 * s()),
            ],
        ),
        (
            "fan",
            vec![
                rod(15.0, -15.0, 15.0),
                block([5.0, -12.0, -2.0], [80.0 * s(), 12.0, 2.0]).placed(about(x, 25.0), [0.0; 3]),
                block([5.0, -12.0, -2.0], [80.0, 12.0, 2.0])
                    .placed(about(Vector3::z(), 120.0) * about(x, 25.0), [0.0; 3]),
                block([5.0, -12.0, -2.0], [80.0, 12.0, 2.0])
                    .placed(about(Vector3::z(), 240.0) * about(x, 25.0), [0.0; 3]),
            ],
        ),
        (
            "screwdriver",
            vec![
                rod(14.0 * s(), 0.0, 90.0),
                rod(4.0, 80.0, 180.0),
                block([-5.0, -1.0, 170.0], [5.0, 1.0, 185.0 * s()]),
            ],
        ),
        (
            "key",
            vec![
                ring(12.0 * s(), 4.0),
                block([10.0, -2.5, -2.0], [60.0 * s(), 2.5, 2.0]),
                block([48.0, -9.0, -1.5], [53.0, 0.0, 1.5]),
            ],
        ),
        (
            "bench of blocks",
            vec![
                block([0.0, 0.0, 0.0], [20.0, 40.0, 30.0]),
                block([80.0, 0.0, 0.0], [100.0, 40.0, 30.0]),
                block([0.0, 0.0, 30.0], [100.0, 40.0, 40.0 + 3.0 * s()]),
            ],
        ),
        (
            "core in a case",
            vec![
                block([-30.0, -20.0, -20.0], [30.0 * s(), 20.0, 20.0]),
                ball(14.0 * s()),
                ball(6.0).at([2.0, 0.0, 1.0]),
            ],
        ),
        (
            "chain of two links",
            vec![
                ring(25.0 * s(), 6.0),
                ring(25.0, 6.0 * s()).placed(about(x, 70.0), [33.0, 2.0, 1.0]),
                rod(9.0, -4.0, 4.0).at([-25.0, 0.0, 0.0]),
                rod(9.0, -30.0, 30.0).placed(about(x, 83.0), [8.0, 1.0, 2.0]),
            ],
        ),
    ];
    for (n, (_, solids)) in all.iter_mut().enumerate() {
        let turn = Rotation3::from_euler_angles(0.3 + n as f64, 0.7 * n as f64, 1.1);
        for solid in solids.iter_mut() {
            *solid = solid.clone().placed(turn, [5.0, -3.0, 2.0]);
        }
    }
    all
}

fn contains(solids: &[Solid], point: &Point3<f64>) -> bool {
    let convex = solids.iter().flat_map(|solid| &solid.convex);
    let inside = |planes: &Convex| planes.iter().all(|(n, d)| n.dot(&point.coords) <= *d);
    convex.into_iter().any(inside)
}

/// Distance that a step may take a point past a surface nearby: how far the union's membership is unsure.
fn near_surface(solids: &[Solid], point: &Point3<f64>, within: f64) -> bool {
    let offsets = [-within, within];
    let all = offsets
        .iter()
        .flat_map(|&x| offsets.iter().map(move |&y| (x, y)));
    let corners = all.flat_map(|(x, y)| offsets.iter().map(move |&z| Vector3::new(x, y, z)));
    let here = contains(solids, point);
    corners
        .into_iter()
        .any(|by| contains(solids, &(point + by)) != here)
}

/// Volume and centre of mass by the midpoint rule over lines along z.
fn by_lines(solids: &[Solid], [low, high]: &[Point3<f64>; 2], lines: usize) -> (f64, Point3<f64>) {
    let size = high - low;
    let (dx, dy) = (size.x / lines as f64, size.y / lines as f64);
    let (mut volume, mut moment) = (0.0, Vector3::zeros());
    for i in 0..lines {
        for j in 0..lines {
            let x = low.x + (i as f64 + 0.5) * dx;
            let y = low.y + (j as f64 + 0.5) * dy;
            let mut intervals: Vec<[f64; 2]> = Vec::new();
            for planes in solids.iter().flat_map(|solid| &solid.convex) {
                let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
                for (n, d) in planes {
                    let left = d - n.x * x - n.y * y;
                    if n.z > 0.0 {
                        to = to.min(left / n.z);
                    } else if n.z < 0.0 {
                        from = from.max(left / n.z);
                    } else if left < 0.0 {
                        to = f64::NEG_INFINITY;
                    }
                }
                if from < to {
                    intervals.push([from, to]);
                }
            }
            intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mut reached = f64::NEG_INFINITY;
            for [from, to] in intervals {
                let from = from.max(reached);
                if to > from {
                    let length = (to - from) * dx * dy;
                    volume += length;
                    moment += Vector3::new(x, y, (from + to) / 2.0) * length;
                    reached = to;
                }
            }
        }
    }
    (volume, Point3::from(moment / volume))
}

fn shuffled(raw: &RawMesh, seed: u64) -> RawMesh {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut raw = raw.clone();
    for last in (1..raw.triangles.len()).rev() {
        let other = (rng.next_u64() % (last as u64 + 1)) as usize;
        raw.triangles.swap(last, other);
    }
    raw
}

fn joined(solids: &[Solid]) -> RawMesh {
    let parts: Vec<RawMesh> = solids.iter().map(|solid| solid.raw.clone()).collect();
    join(&parts)
}

#[test]
fn everyday_composites_are_weighed_and_touched_as_their_union() {
    for seed in [1, 2] {
        for (name, solids) in things(seed) {
            let raw = joined(&solids);
            let mesh = Mesh::prepare(raw.clone()).unwrap();
            let report = mesh.report();
            let (volume, center) = by_lines(&solids, &report.bounds, 300);
            let found = report.volume.unwrap();
            assert!(
                (found / volume - 1.0).abs() < 4e-3,
                "{name}: {found} for {volume}"
            );
            let off = (report.center_of_mass - center).norm() / report.bounding_radius;
            assert!(off < 1e-3, "{name}: the centre is off by {off}");
            if let Some(bound) = report.volume_bound {
                assert!(bound < 1e-3, "{name}: {bound}");
            }
            let step = 1e-4 * (report.bounds[1] - report.bounds[0]).norm();
            let uniform = mesh
                .uniform_candidates(500, seed, Interrupt::never())
                .unwrap();
            assert_eq!(uniform.len(), 500);
            for candidate in mesh.candidates().into_iter().chain(uniform) {
                if near_surface(&solids, &candidate.position, 0.3 * step) {
                    let above = candidate.position - candidate.normal.into_inner() * step;
                    let below = candidate.position + candidate.normal.into_inner() * step;
                    assert!(!contains(&solids, &above), "{name}: buried {candidate:?}");
                    assert!(contains(&solids, &below), "{name}: pulls {candidate:?}");
                } else {
                    panic!("{name}: not on the surface of the union: {candidate:?}");
                }
            }
            // Whatever is left out lies in matter, or is flush with the same face of another solid.
            for &number in mesh.source() {
                if let Err(NoCandidate::Buried(_)) = mesh.candidate_of(number) {
                    let index = mesh.source().binary_search(&number).unwrap();
                    let corners = triangle::corners(mesh.vertices(), mesh.triangles()[index]);
                    let outward = triangle::normal(&corners).normalize() * step;
                    let at = triangle::centroid(&corners);
                    let filled = solids
                        .iter()
                        .filter(|solid| contains(std::slice::from_ref(*solid), &(at - outward)));
                    let buried = contains(&solids, &(at + outward)) || filled.count() > 1;
                    assert!(buried, "{name}: triangle {number}");
                }
            }
        }
    }
}

#[test]
fn the_order_of_triangles_changes_nothing() {
    for (name, solids) in things(3) {
        let raw = joined(&solids);
        let plain = Mesh::prepare(raw.clone()).unwrap().report().clone();
        for seed in 0..2 {
            let other = Mesh::prepare(shuffled(&raw, seed))
                .unwrap()
                .report()
                .clone();
            let volume = other.volume.unwrap() / plain.volume.unwrap() - 1.0;
            let off = (other.center_of_mass - plain.center_of_mass).norm();
            let bound = plain.volume_bound.unwrap_or(0.0) + 1e-12;
            assert!(volume.abs() <= bound, "{name}: {volume}");
            assert!(off <= bound * plain.bounding_radius, "{name}: {off}");
            assert_eq!(
                (
                    plain.candidates,
                    plain.buried_triangles,
                    plain.enclosed_triangles
                ),
                (
                    other.candidates,
                    other.buried_triangles,
                    other.enclosed_triangles
                ),
                "{name}"
            );
            assert_eq!(
                (plain.overlapping_parts, plain.body_count, plain.mass_from),
                (other.overlapping_parts, other.body_count, other.mass_from),
                "{name}"
            );
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let (_, solids) = things(4).swap_remove(5);
    let raw = joined(&solids);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| Mesh::prepare(raw.clone()).unwrap())
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.report(), three.report());
    assert_eq!(
        (one.triangles(), &one.cover),
        (three.triangles(), &three.cover)
    );
}

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
