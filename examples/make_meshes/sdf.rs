//! Signed distances: negative inside, positive outside, in the unit of the body.
//!
//! Only `+ - * /` and `sqrt` are used. They are exact to the last bit on every machine, while sines
//! and logarithms are not, and the meshes have to come out the same everywhere.

use fast_surface_nets::glam::{DVec2, DVec3};

/// A body: the signed distance to its surface, or a bound of it that is zero on the same surface.
pub type Field = dyn Fn(DVec3) -> f64;

/// The mirror image of a point in the plane y = 0, on the positive side: what is drawn on the left
/// appears on the right as well.
pub fn mirrored(p: DVec3) -> DVec3 {
    DVec3::new(p.x, p.y.abs(), p.z)
}

pub fn sphere(p: DVec3, centre: DVec3, radius: f64) -> f64 {
    p.distance(centre) - radius
}

/// An ellipsoid along the axes. Not the exact distance, but zero and of unit slope on the surface.
pub fn ellipsoid(p: DVec3, centre: DVec3, radii: DVec3) -> f64 {
    let q = (p - centre) / radii;
    let scaled = q.length();
    let slope = (q / radii).length();
    if slope < 1e-12 {
        -radii.min_element()
    } else {
        scaled * (scaled - 1.0) / slope
    }
}

/// An ellipsoid whose first radius lies along `along`, its third as near to `up` as it can.
pub fn tilted_ellipsoid(p: DVec3, centre: DVec3, along: DVec3, up: DVec3, radii: DVec3) -> f64 {
    let x = along.normalize();
    let y = up.cross(x).normalize();
    let z = x.cross(y);
    let d = p - centre;
    ellipsoid(DVec3::new(d.dot(x), d.dot(y), d.dot(z)), DVec3::ZERO, radii)
}

/// The hull of two balls, `ra` at `a` and `rb` at `b`: limbs, ears, beaks, locks of hair.
pub fn round_cone(p: DVec3, a: DVec3, b: DVec3, ra: f64, rb: f64) -> f64 {
    let axis = b - a;
    let length2 = axis.length_squared();
    let dr = ra - rb;
    let slant2 = length2 - dr * dr;
    let from_a = p - a;
    let along = from_a.dot(axis);
    let beyond = along - length2;
    let across2 = (from_a * length2 - axis * along).length_squared();
    let along2 = along * along * length2;
    let beyond2 = beyond * beyond * length2;
    let k = dr.signum() * dr * dr * across2;
    if beyond.signum() * slant2 * beyond2 > k {
        (across2 + beyond2).sqrt() / length2 - rb
    } else if along.signum() * slant2 * along2 < k {
        (across2 + along2).sqrt() / length2 - ra
    } else {
        ((across2 * slant2 / length2).sqrt() + along * dr) / length2 - ra
    }
}

/// A ring around the z axis at height `z`.
pub fn ring(p: DVec3, z: f64, radius: f64, thickness: f64) -> f64 {
    let from_axis = p.truncate().length() - radius;
    DVec2::new(from_axis, p.z - z).length() - thickness
}

/// A disc around the z axis from height `low` to `high` with its rim rounded off.
pub fn disc(p: DVec3, low: f64, high: f64, radius: f64, rim: f64) -> f64 {
    let half = (high - low) / 2.0;
    let q = DVec2::new(
        p.truncate().length() - radius + rim,
        (p.z - low - half).abs() - half + rim,
    );
    q.max_element().min(0.0) + q.max(DVec2::ZERO).length() - rim
}

/// Both bodies, their seam filleted over about `k`.
pub fn union(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k / 4.0
}

/// What both bodies share, the edge rounded over about `k`.
pub fn intersection(a: f64, b: f64, k: f64) -> f64 {
    -union(-a, -b, k)
}

/// The first body without the second, the edge rounded over about `k`.
pub fn carved(a: f64, tool: f64, k: f64) -> f64 {
    intersection(a, -tool, k)
}

/// 0 below `low`, 1 above `high`, smooth between.
pub fn smoothstep(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A closed curve in a plane, for silhouettes and turned profiles.
pub struct Outline(Vec<DVec2>);

impl Outline {
    /// The polygon through `corners`.
    pub fn polygon(corners: &[(f64, f64)]) -> Self {
        Self(corners.iter().map(|&(x, y)| DVec2::new(x, y)).collect())
    }

    /// A smooth closed curve through `points` (Catmull-Rom), as a polygon of small steps.
    pub fn smooth(points: &[(f64, f64)]) -> Self {
        const STEPS: usize = 6;
        let n = points.len();
        let at = |i: usize| DVec2::from(points[i % n]);
        let mut curve = Vec::with_capacity(n * STEPS);
        for i in 0..n {
            let [a, b, c, d] = [at(i + n - 1), at(i), at(i + 1), at(i + 2)];
            for step in 0..STEPS {
                let t = step as f64 / STEPS as f64;
                let bend =
                    (a * 2.0 - b * 5.0 + c * 4.0 - d) * t + (b * 3.0 - a - c * 3.0 + d) * t * t;
                curve.push(b + ((c - a) + bend) * (t / 2.0));
            }
        }
        Self(curve)
    }

    /// Signed distance in the plane; the direction of travel does not matter.
    pub fn distance(&self, p: DVec2) -> f64 {
        let mut nearest = f64::INFINITY;
        let mut inside = false;
        let mut previous = self.0[self.0.len() - 1];
        for &corner in &self.0 {
            let edge = previous - corner;
            let to_p = p - corner;
            let t = (to_p.dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
            nearest = nearest.min((to_p - edge * t).length_squared());
            let crosses = (corner.y > p.y) != (previous.y > p.y);
            if crosses && p.x < corner.x + edge.x * (p.y - corner.y) / edge.y {
                inside = !inside;
            }
            previous = corner;
        }
        if inside {
            -nearest.sqrt()
        } else {
            nearest.sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primitives_are_zero_on_their_surfaces() {
        let at = DVec3::new;
        assert!(sphere(at(3.0, 0.0, 0.0), DVec3::X, 2.0).abs() < 1e-12);
        assert!(ellipsoid(at(0.0, 2.0, 0.0), DVec3::ZERO, at(1.0, 2.0, 3.0)).abs() < 1e-12);
        assert!(
            round_cone(at(0.0, 0.0, 5.5), DVec3::ZERO, at(0.0, 0.0, 5.0), 1.0, 0.5).abs() < 1e-12
        );
        assert!(ring(at(2.5, 0.0, 1.0), 1.0, 2.0, 0.5).abs() < 1e-12);
        assert!(disc(at(0.0, 2.0, 0.5), 0.0, 1.0, 2.0, 0.2).abs() < 1e-12);
        let square = Outline::polygon(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]);
        assert_eq!(square.distance(DVec2::new(1.0, 1.0)), -1.0);
        assert_eq!(square.distance(DVec2::new(1.0, 3.0)), 1.0);
    }
}
