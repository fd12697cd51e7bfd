//! The rubber duck, in millimetres.

use super::Body;
use crate::sdf::{ellipsoid, intersection, mirrored, round_cone, sphere, tilted_ellipsoid, union};
use fast_surface_nets::glam::DVec3;

pub fn body() -> Body {
    Body {
        field: Box::new(|p| duck(mirrored(p))),
        min: DVec3::new(-50.0, -34.0, -1.0),
        max: DVec3::new(52.0, 34.0, 82.0),
        step: 1.4,
        triangles: 8_228,
    }
}

/// Half of the duck; the other half is its mirror image.
fn duck(p: DVec3) -> f64 {
    let at = DVec3::new;
    // Body, a full breast and the tail drawn out and up.
    let mut d = ellipsoid(p, at(-3.0, 0.0, 21.0), at(35.0, 27.0, 23.0));
    d = union(
        d,
        ellipsoid(p, at(12.0, 0.0, 23.0), at(22.0, 23.0, 20.0)),
        8.0,
    );
    d = union(
        d,
        round_cone(p, at(-26.0, 0.0, 26.0), at(-42.0, 0.0, 44.0), 13.0, 3.4),
        9.0,
    );
    // Flat underneath: it floats, and stands.
    d = intersection(d, -p.z, 6.0);

    // Wings, lifted off the flanks at their tips.
    let wing = tilted_ellipsoid(
        p,
        at(-8.0, 24.0, 27.0),
        at(-1.0, 0.12, 0.28),
        at(0.0, -0.25, 1.0),
        at(20.0, 5.5, 11.0),
    );
    d = union(d, wing, 1.5);
    d = union(
        d,
        round_cone(p, at(-16.0, 25.5, 29.0), at(-30.0, 27.5, 36.0), 5.4, 3.0),
        4.0,
    );

    // Head.
    d = union(
        d,
        round_cone(p, at(13.0, 0.0, 38.0), at(15.0, 0.0, 58.0), 16.0, 18.5),
        7.0,
    );
    d = union(
        d,
        ellipsoid(p, at(21.0, 10.0, 54.0), at(11.0, 8.0, 8.0)),
        5.0,
    );

    // Bill: two lips, the upper one turned up at its end.
    let mut upper = tilted_ellipsoid(
        p,
        at(37.0, 0.0, 57.6),
        at(1.0, 0.0, 0.12),
        DVec3::Z,
        at(13.0, 10.6, 3.7),
    );
    upper = union(
        upper,
        ellipsoid(p, at(45.5, 0.0, 60.2), at(5.6, 8.0, 2.8)),
        4.0,
    );
    let lower = tilted_ellipsoid(
        p,
        at(34.0, 0.0, 48.6),
        at(1.0, 0.0, -0.2),
        DVec3::Z,
        at(11.5, 8.8, 3.5),
    );
    d = union(d, union(upper, lower, 1.0), 3.5);

    // Eyes, and a tuft.
    d = union(d, sphere(p, at(26.4, 9.9, 66.0), 4.4), 1.0);
    union(
        d,
        round_cone(p, at(12.0, 0.0, 75.0), at(4.5, 0.0, 79.5), 3.6, 2.2),
        4.0,
    )
}
