//! Everyday things as unions of solids.

use nalgebra::{Point3, Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::convex::{Convex, Solid, convex};
use crate::mesh::solids::{cuboid, sphere, torus};
use crate::mesh::{RawMesh, triangle};

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

pub(super) fn cylinder(radius: f64, low: f64, high: f64) -> RawMesh {
    turned(&[[radius, low], [radius, high]], 40)
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

fn block(low: [f64; 3], high: [f64; 3]) -> Solid {
    convex(cuboid(low, high))
}

fn about(axis: Vector3<f64>, degrees: f64) -> Rotation3<f64> {
    Rotation3::new(axis * degrees.to_radians())
}

/// The things, in millimetres; sizes vary with the seed by a tenth.
pub(super) fn things(seed: u64) -> Vec<(&'static str, Vec<Solid>)> {
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
