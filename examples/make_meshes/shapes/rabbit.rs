//! The sitting rabbit with its long ears, in millimetres.

use super::Body;
use crate::sdf::{
    carved, ellipsoid, intersection, mirrored, round_cone, sphere, tilted_ellipsoid, union,
};
use fast_surface_nets::glam::DVec3;

pub fn body() -> Body {
    Body {
        field: Box::new(rabbit),
        min: DVec3::new(-52.0, -32.0, -1.0),
        max: DVec3::new(50.0, 34.0, 126.0),
        step: 1.0,
        triangles: 33_352,
    }
}

/// All but the ears is symmetrical; the left ear hangs further back than the right one.
fn rabbit(p: DVec3) -> f64 {
    let m = mirrored(p);
    let at = DVec3::new;
    let mut d = union(trunk(m), legs(m), 2.5);
    d = intersection(d, -p.z, 1.5);
    d = union(d, head(m), 7.0);
    d = union(
        d,
        ear(
            p,
            at(19.0, 5.6, 78.0),
            at(-4.0, 13.0, 115.0),
            at(0.55, 0.8, 0.25),
        ),
        3.0,
    );
    union(
        d,
        ear(
            p,
            at(20.0, -5.6, 78.5),
            at(9.0, -12.0, 121.0),
            at(0.75, -0.65, 0.2),
        ),
        3.0,
    )
}

fn trunk(p: DVec3) -> f64 {
    let at = DVec3::new;
    let mut d = tilted_ellipsoid(
        p,
        at(-8.0, 0.0, 29.0),
        at(0.93, 0.0, 0.36),
        DVec3::Z,
        at(33.0, 20.0, 25.0),
    );
    d = union(
        d,
        ellipsoid(p, at(13.0, 0.0, 34.0), at(14.0, 14.0, 20.0)),
        8.0,
    );
    d = union(
        d,
        round_cone(p, at(13.0, 0.0, 46.0), at(22.0, 0.0, 64.0), 12.5, 10.0),
        8.0,
    );
    // A tail of wool.
    let mut tail = sphere(p, at(-40.0, 0.0, 17.0), 7.4);
    for (x, y, z) in [
        (-44.0, 0.0, 20.5),
        (-43.5, 4.0, 15.5),
        (-40.0, 4.6, 20.5),
        (-42.5, 0.0, 12.0),
    ] {
        tail = union(tail, sphere(p, at(x, y, z), 4.2), 1.6);
    }
    union(d, tail, 2.0)
}

fn legs(p: DVec3) -> f64 {
    let at = DVec3::new;
    // Haunch and the long hind foot under it.
    let mut d = tilted_ellipsoid(
        p,
        at(-14.0, 15.5, 21.0),
        at(0.8, 0.12, 0.6),
        at(-0.6, 0.0, 0.8),
        at(18.5, 9.0, 16.5),
    );
    d = union(
        d,
        round_cone(p, at(-18.0, 18.0, 4.4), at(12.0, 19.5, 4.4), 5.0, 5.2),
        4.0,
    );
    // Foreleg and paw.
    d = union(
        d,
        round_cone(p, at(17.0, 7.6, 30.0), at(24.5, 7.4, 6.0), 6.6, 4.4),
        3.0,
    );
    d = union(d, ellipsoid(p, at(28.0, 7.4, 3.8), at(7.0, 4.8, 4.2)), 2.0);
    // Toes are what is left between two grooves.
    for (x, y, z) in [
        (17.6, 18.0, 5.5),
        (17.6, 21.0, 5.5),
        (35.4, 5.9, 4.8),
        (35.4, 8.9, 4.8),
    ] {
        d = carved(
            d,
            round_cone(p, at(x, y, z - 4.0), at(x - 3.0, y, z + 3.4), 0.9, 0.7),
            0.9,
        );
    }
    d
}

fn head(p: DVec3) -> f64 {
    let at = DVec3::new;
    let mut d = tilted_ellipsoid(
        p,
        at(26.0, 0.0, 69.0),
        at(0.96, 0.0, -0.28),
        DVec3::Z,
        at(16.0, 11.0, 12.0),
    );
    d = union(d, sphere(p, at(29.0, 5.4, 63.5), 7.2), 4.0);
    d = union(d, ellipsoid(p, at(38.5, 2.6, 62.6), at(5.2, 4.2, 4.6)), 2.5);
    d = union(d, ellipsoid(p, at(39.0, 0.0, 59.2), at(3.4, 3.4, 2.6)), 1.2);
    d = union(d, ellipsoid(p, at(42.6, 0.0, 66.3), at(2.0, 2.4, 1.7)), 0.8);
    // The cleft lip, and the eye in its lid.
    d = carved(
        d,
        round_cone(p, at(44.6, 0.0, 64.0), at(43.6, 0.0, 60.0), 0.9, 0.9),
        0.9,
    );
    d = carved(d, sphere(p, at(33.6, 11.2, 71.4), 4.2), 1.6);
    union(d, sphere(p, at(32.2, 7.9, 71.2), 3.7), 0.8)
}

/// A long flat ear from `root` to `tip`, hollow on the side that `open` faces.
fn ear(p: DVec3, root: DVec3, tip: DVec3, open: DVec3) -> f64 {
    let along = tip - root;
    let half = along.length() / 2.0;
    let middle = (root + tip) / 2.0;
    let mut d = tilted_ellipsoid(p, middle, along, open, DVec3::new(half + 3.0, 7.6, 3.4));
    d = union(
        d,
        round_cone(p, root - along * 0.1, root + along * 0.25, 4.6, 3.4),
        4.0,
    );
    let open = open.reject_from(along).normalize();
    let hollow = tilted_ellipsoid(
        p,
        middle + open * 3.6,
        along,
        open,
        DVec3::new(half - 1.5, 4.9, 3.9),
    );
    carved(d, hollow, 1.4)
}
