//! Which closed parts of a surface bound cavities: those inside an odd number of others.
//!
//! A part is inside another when a point just under its own surface is. Whether the point is, the generalised
//! winding number of the other part about it decides (Jacobson, Kavan and Sorkine-Hornung, "Robust inside-outside
//! segmentation using generalized winding numbers", ACM TOG 32, 2013): the solid angles of all triangles seen from
//! the point, summed with the sign of their winding, make a full sphere when the part encloses it and nothing when
//! it does not. Unlike a ray, the sum cannot hit an edge or a vertex and count it twice, and halfway between the
//! two values is far from any rounding.
//!
//! ```text
//! for each closed part:
//!     point = the centroid of its largest triangle, one welding tolerance further in
//!     depth = how many other closed parts enclose point
//!     it bounds a cavity if depth is odd
//! ```
//!
//! **Cost:** a box test for every pair of closed parts, and a solid angle for every triangle of a part whose box
//! holds the point. Real bodies have few parts. A file made to hurt has a hundred thousand, each inside the next,
//! so the work is counted and ends at [`MAX_WORK`]. Parts that cross each other have no right answer.

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3};

use super::parts::Part;
use super::{triangle, weld};

/// Most work spent on the question, in box tests: about a second.
///
/// Real bodies stay a thousand times below. Past it, the parts not yet looked at count as not enclosed.
const MAX_WORK: u64 = 1 << 30;

/// Time of one solid angle over that of one box test.
const ANGLE_WORK: u64 = 32;

/// For each part whether it is closed and an odd number of other closed parts encloses it.
///
/// Closed parts must be wound outward; `tolerance` is that of welding.
pub(super) fn cavities(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    parts: &[Part],
    tolerance: f64,
) -> Vec<bool> {
    let mut cavity = vec![false; parts.len()];
    let shells: Vec<Shell> = parts
        .iter()
        .enumerate()
        .filter(|(_, part)| part.closed)
        .map(|(n, part)| Shell::new(n, part, vertices, triangles, tolerance))
        .collect();
    let mut work = 0;
    for inner in &shells {
        let mut depth = 0;
        for outer in shells.iter().filter(|outer| outer.part != inner.part) {
            work += 1;
            if outer.box_contains(&inner.inside) {
                work += ANGLE_WORK * outer.triangles.len() as u64;
                depth += u32::from(outer.contains(&inner.inside, vertices, triangles));
            }
            if work > MAX_WORK {
                return cavity;
            }
        }
        cavity[inner.part] = depth % 2 == 1;
    }
    cavity
}

/// A closed part, ready for the test.
struct Shell<'a> {
    part: usize,
    triangles: &'a [u32],
    low: Point3<f64>,
    high: Point3<f64>,
    /// A point that the part encloses, close to its surface.
    inside: Point3<f64>,
}

impl<'a> Shell<'a> {
    fn new(
        n: usize,
        part: &'a Part,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        tolerance: f64,
    ) -> Self {
        let all = || {
            part.triangles
                .iter()
                .map(|&n| triangle::corners(vertices, triangles[n as usize]))
        };
        let (low, high) = weld::bounds(all().flatten());
        let largest = all().max_by(|a, b| triangle::area(a).total_cmp(&triangle::area(b)));
        // Nothing is thinner than the welding tolerance, so a step of that length into the part
        // stays in it, and leaves any surface of another part that touches it here.
        let inside = largest.map_or(low, |corners| {
            let inward = -triangle::normal(&corners);
            triangle::centroid(&corners)
                + inward
                    .try_normalize(0.0)
                    .map_or(Vector3::zeros(), |inward| inward * tolerance)
        });
        Self {
            part: n,
            triangles: &part.triangles,
            low,
            high,
            inside,
        }
    }

    fn box_contains(&self, point: &Point3<f64>) -> bool {
        self.low <= *point && *point <= self.high
    }

    fn contains(
        &self,
        point: &Point3<f64>,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
    ) -> bool {
        let solid_angle: f64 = self
            .triangles
            .iter()
            .map(|&n| triangle::corners(vertices, triangles[n as usize]))
            .map(|corners| solid_angle(&corners, point))
            .sum();
        // A full sphere is 4π; anything nearer to it than to nothing counts.
        solid_angle.abs() > 2.0 * PI
    }
}

/// Signed solid angle of a triangle seen from `point`.
///
/// The tangent of half of it is a quotient of products of the corners (Van Oosterom and Strackee, "The solid angle
/// of a plane triangle", IEEE Trans. Biomed. Eng. 30, 1983), so `atan2` gives the right value past a hemisphere too.
fn solid_angle(corners: &[Point3<f64>; 3], point: &Point3<f64>) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let numerator = a.dot(&b.cross(&c));
    let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * numerator.atan2(denominator)
}
