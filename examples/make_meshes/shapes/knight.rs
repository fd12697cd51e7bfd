//! The chess knight: a turned foot and a horse's head cut from a silhouette, in millimetres.

use super::Body;
use crate::sdf::{
    Outline, carved, disc, ellipsoid, intersection, mirrored, ring, round_cone, smoothstep, sphere,
    union,
};
use fast_surface_nets::glam::{DVec2, DVec3};

pub fn body() -> Body {
    let head = Outline::smooth(&HEAD);
    let mouth = Outline::polygon(&MOUTH);
    let stem = Outline::polygon(&STEM);
    Body {
        field: Box::new(move |p| {
            let foot = foot(&stem, p);
            let horse = horse(&head, &mouth, mirrored(p));
            union(foot, horse, 1.6)
        }),
        min: DVec3::new(-18.0, -16.0, -1.0),
        max: DVec3::new(20.0, 16.0, 61.0),
        step: 0.5,
        triangles: 21_358,
    }
}

/// Silhouette of head and neck from the side (x, z), from the nape over ears, nose and throat.
const HEAD: [(f64, f64); 27] = [
    (-8.6, 13.0),
    (-9.6, 18.0),
    (-11.4, 24.0),
    (-12.3, 30.0),
    (-12.1, 36.0),
    (-10.8, 42.0),
    (-8.3, 47.6),
    (-4.8, 51.8),
    (-1.0, 53.9),
    (2.2, 53.2),
    (5.0, 50.2),
    (7.6, 46.6),
    (10.4, 42.8),
    (13.2, 39.4),
    (15.2, 36.6),
    (15.9, 33.6),
    (14.9, 31.2),
    (12.0, 30.0),
    (9.3, 31.4),
    (6.6, 33.8),
    (3.6, 34.4),
    (1.6, 32.6),
    (2.6, 29.4),
    (5.6, 25.4),
    (8.2, 21.0),
    (8.9, 17.0),
    (8.6, 13.0),
];

/// The wedge between the lips (x, z).
const MOUTH: [(f64, f64); 3] = [(19.0, 34.6), (10.2, 34.3), (19.0, 31.2)];

/// Turned profile of the stem (distance from the axis, z), well past the axis on the inside.
const STEM: [(f64, f64); 9] = [
    (-6.0, 2.0),
    (12.6, 2.0),
    (12.2, 6.0),
    (10.6, 7.6),
    (9.3, 9.4),
    (8.5, 11.4),
    (8.2, 13.4),
    (8.3, 15.0),
    (-6.0, 15.0),
];

fn foot(stem: &Outline, p: DVec3) -> f64 {
    let mut d = disc(p, 0.0, 4.4, 14.6, 1.4);
    d = union(
        d,
        stem.distance(DVec2::new(p.truncate().length(), p.z)),
        0.8,
    );
    d = union(d, ring(p, 6.1, 11.8, 1.5), 1.6);
    d = union(d, disc(p, 13.2, 15.8, 10.2, 1.2), 1.0);
    d
}

/// Half of the horse; the other half is its mirror image.
fn horse(head: &Outline, mouth: &Outline, p: DVec3) -> f64 {
    let at = DVec3::new;
    // The muzzle is slimmer than the brow, and the throat drawn in.
    let muzzle = smoothstep(3.0, 15.0, p.x) * smoothstep(27.0, 33.0, p.z);
    let throat = smoothstep(-2.0, 3.0, p.x)
        * smoothstep(24.0, 28.0, p.z)
        * (1.0 - smoothstep(32.0, 37.0, p.z));
    let half = half_width(p.z) - 1.5 * muzzle - 0.9 * throat;
    let mut d = intersection(head.distance(DVec2::new(p.x, p.z)), p.y - half, 5.5);

    // Cheek, brow, nose bone and lips.
    d = union(d, ellipsoid(p, at(3.4, 3.4, 39.8), at(5.2, 2.9, 5.4)), 1.6);
    d = union(
        d,
        round_cone(p, at(3.0, 3.9, 48.0), at(6.6, 3.4, 45.8), 1.5, 1.0),
        1.4,
    );
    d = union(d, ellipsoid(p, at(13.3, 2.2, 35.0), at(2.4, 2.0, 2.6)), 1.6);

    // Eye in its socket, nostril, mouth.
    d = carved(d, ellipsoid(p, at(5.3, 5.9, 44.6), at(2.3, 1.6, 1.8)), 0.9);
    d = union(d, sphere(p, at(5.3, 4.0, 44.6), 1.35), 0.7);
    d = carved(d, ellipsoid(p, at(14.6, 3.4, 36.2), at(1.1, 1.2, 0.8)), 0.7);
    d = carved(d, mouth.distance(DVec2::new(p.x, p.z)), 0.8);

    // Ear, hollow to the front.
    d = union(
        d,
        round_cone(p, at(-1.5, 2.7, 50.0), at(0.4, 3.3, 58.2), 2.7, 0.75),
        1.2,
    );
    d = carved(
        d,
        round_cone(p, at(0.9, 4.3, 53.3), at(0.95, 3.9, 57.0), 1.1, 0.5),
        0.7,
    );

    // Mane: locks that start on the side of the neck and sweep down and back over the crest.
    for [x, z, lift] in LOCKS {
        let root = at(x + 5.6, half_width(z) - 0.4, z + lift);
        let middle = at(x + 2.3, half_width(z) - 1.8, z + lift / 4.0);
        let tip = at(x - 0.8, 0.8, z - 1.3);
        d = union(d, round_cone(p, root, middle, 0.6, 1.7), 1.0);
        d = union(d, round_cone(p, middle, tip, 1.7, 1.1), 1.0);
    }
    d
}

/// Half the thickness of the neck at height `z`: broad at the shoulders, slim at the poll.
fn half_width(z: f64) -> f64 {
    7.9 - 3.0 * smoothstep(15.0, 50.0, z)
}

/// Where each lock of the mane crosses the crest (x, z), and how far its root rises above that.
const LOCKS: [[f64; 3]; 9] = [
    [-4.2, 52.6, -3.0],
    [-7.2, 49.4, -1.0],
    [-9.4, 45.9, 0.8],
    [-10.9, 42.1, 1.8],
    [-11.8, 38.1, 2.4],
    [-12.2, 34.0, 2.6],
    [-12.2, 29.8, 2.8],
    [-11.8, 25.6, 3.0],
    [-10.8, 21.4, 3.0],
];
