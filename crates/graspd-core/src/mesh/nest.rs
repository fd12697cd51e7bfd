//! Which closed parts of a surface are cavities: those inside an odd number of others.

use std::f64::consts::PI;

use nalgebra::{Point3, Vector3};

use super::orient::Part;
use super::{triangle, weld};

/// Most work spent on the question, in box tests: about a second.
///
/// Real bodies stay a thousand times below. A hostile file of a hundred thousand tiny solids, one
/// inside the other, would otherwise take hours; its last solids count as not enclosed.
const MAX_WORK: u64 = 1 << 30;

/// Time of one solid angle over the time of one box test.
const ANGLE_WORK: u64 = 32;

/// For each part whether it is closed and an odd number of other closed parts encloses it.
///
/// Closed parts must be wound outward. A part is enclosed when the generalised winding number
/// (Jacobson et al. 2013) of the other part about a point just inside it is nearer to one than to
/// zero; no ray has to miss edges and vertices. Parts that cross each other have no right answer.
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
                work += ANGLE_WORK * outer.corners.len() as u64;
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
    corners: &'a [u32],
    low: Point3<f64>,
    high: Point3<f64>,
    /// A point of the space that the part encloses, close to its surface.
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
            corners: &part.triangles,
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
            .corners
            .iter()
            .map(|&n| triangle::corners(vertices, triangles[n as usize]))
            .map(|corners| solid_angle(&corners, point))
            .sum();
        solid_angle.abs() > 2.0 * PI
    }
}

/// Signed solid angle of a triangle seen from `point` (Van Oosterom & Strackee 1983).
fn solid_angle(corners: &[Point3<f64>; 3], point: &Point3<f64>) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let numerator = a.dot(&b.cross(&c));
    let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * numerator.atan2(denominator)
}
