//! The polygon that the contacts span.

use std::f64::consts::PI;

use nalgebra::{Matrix3, SymmetricEigen, Vector2, Vector3};

use crate::contact::Contact;

/// The contacts lie on a line when their mean square distance from it is no more than this share of
/// that along it, and have no plane of their own when the mean squares across two planes differ by no
/// more: rounding, some hundred units of 2⁻⁵², would then turn the plane by more than 10⁻⁵.
pub const PLANE_TOLERANCE: f64 = 1e-9;

/// A contact is a corner when the triangle that it makes with its neighbours has more than this of
/// the squared extent of the polygon: a thousandfold reserve over the rounding of the projection.
pub const CORNER_TOLERANCE: f64 = 1e-12;

/// Steps after which the search for principal axes gives up; three by three needs a handful.
const MAX_SWEEPS: usize = 100;

/// The convex polygon that the contacts span in the plane that fits them best.
///
/// The plane goes through the mean of the positions and leaves the least sum of squared distances; the
/// contacts are projected to it at right angles. A contact inside the polygon counts as one on its
/// border, with an inner angle of π, so that the angles always sum to π(m−2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polygon {
    /// In the mesh's unit squared.
    pub area: f64,
    /// Deviation of the inner angles from those of the regular polygon, 0 to 1; see
    /// [`Measures::polygon_shape`](super::Measures::polygon_shape).
    pub shape: f64,
}

impl Polygon {
    /// `None` for fewer than three contacts, for contacts on one line, and for contacts that no plane
    /// fits better than all others, as the corners of a regular tetrahedron. O(m log m).
    pub fn new(contacts: &[Contact]) -> Option<Self> {
        let first = contacts.first()?.position;
        let m = contacts.len();
        if m < 3 {
            return None;
        }
        let mean = contacts
            .iter()
            .map(|c| c.position - first)
            .sum::<Vector3<f64>>()
            / m as f64;
        let arms: Vec<Vector3<f64>> = contacts
            .iter()
            .map(|c| (c.position - first) - mean)
            .collect();
        let extent = arms.iter().map(|a| a.norm()).fold(0.0, f64::max);
        if extent == 0.0 {
            return None;
        }
        let (u, v) = plane(&arms, extent)?;
        let hull = convex_hull(
            arms.iter()
                .map(|arm| Vector2::new(arm.dot(&u), arm.dot(&v)) / extent)
                .collect(),
        );
        if hull.len() < 3 {
            return None;
        }
        let corner = |i: usize| hull[i % hull.len()];
        let regular = PI * (m - 2) as f64 / m as f64;
        let straight = (m - hull.len()) as f64 * (PI - regular);
        let (mut area, mut deviation) = (0.0, straight);
        for i in 0..hull.len() {
            let (before, here, after) = (corner(i), corner(i + 1), corner(i + 2));
            area += here.perp(&after) / 2.0;
            let (back, on) = (before - here, after - here);
            let angle = on.perp(&back).atan2(on.dot(&back));
            deviation += (angle - regular).abs();
        }
        let worst = (m - 2) as f64 * (PI - regular) + 2.0 * regular;
        Some(Self {
            area: area * extent * extent,
            shape: (deviation / worst).clamp(0.0, 1.0),
        })
    }
}

/// Orthonormal directions of the plane through the mean that fits best, when there is one.
fn plane(arms: &[Vector3<f64>], extent: f64) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let spread: Matrix3<f64> = arms
        .iter()
        .map(|arm| arm / extent)
        .map(|arm| arm * arm.transpose())
        .sum();
    let eigen = SymmetricEigen::try_new(spread, f64::EPSILON, MAX_SWEEPS)?;
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let [most, middle, least] = order.map(|i| eigen.eigenvalues[i]);
    let single = middle > PLANE_TOLERANCE * most && middle - least > PLANE_TOLERANCE * most;
    single.then(|| {
        let axis = |i: usize| eigen.eigenvectors.column(order[i]).into_owned();
        (axis(0), axis(1))
    })
}

/// The corners, counter-clockwise (Andrew's monotone chain).
fn convex_hull(mut points: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<Vector2<f64>> = Vec::with_capacity(2 * points.len());
    for backwards in [false, true] {
        let start = hull.len();
        let mut extend = |point: Vector2<f64>| {
            while let &[.., a, b] = &hull[start..]
                && (b - a).perp(&(point - b)) <= CORNER_TOLERANCE
            {
                hull.pop();
            }
            hull.push(point);
        };
        if backwards {
            points.iter().rev().copied().for_each(&mut extend);
        } else {
            points.iter().copied().for_each(&mut extend);
        }
        // The end of one chain is the start of the other.
        hull.pop();
    }
    hull
}
