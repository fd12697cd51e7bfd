//! Cutting a polygon that a fan about its first corner does not cover.
//!
//! Most polygons of mesh files are convex, and a fan about the first corner is all that they need. Others are cut by ear
//! clipping (Meisters, "Polygons have ears", Amer. Math. Monthly 82, 1975): an ear is a convex corner whose triangle
//! with its two neighbours holds no other corner, and every simple polygon of more than three corners has two of them.
//!
//! ```text
//! fan, if none of its triangles is turned over against the polygon's normal
//! else, in the plane that the polygon is closest to:
//! while more than three corners are left:
//!     find an ear, beginning behind the last one
//!     put out its triangle, remove its corner
//! put out the last three
//! ```
//!
//! **Invariant:** the triangles put out and the polygon that is left cover the original one, each place once. Only
//! reflex corners, which turn to the right, can lie in the triangle of an ear, so only these are tested.
//!
//! **Why it ends:** each round removes a corner, or finds no ear and gives up; that happens only to outlines that cross
//! themselves or enclose nothing. **Cost:** O(c·r) corners looked at for each round, c corners and r reflex ones, so
//! cubic at worst. The work of all polygons of a file is counted and bounded by [`MAX_WORK`].

use nalgebra::{Point2, Point3, Vector3};

/// Most corners looked at to cut the polygons of a file that a fan does not cover: about a second.
pub(super) const MAX_WORK: usize = 1 << 28;

/// Share of the polygon's area that a triangle of a fan may be turned over by; rounding makes less.
const TURNED: f64 = 1e-9;

/// The triangles of a polygon, as indices of its corners: two fewer than corners, wound as they run.
///
/// `None` when the fan about the first corner covers the polygon; when no ear is found; and when `work`, to which the
/// corners looked at are added, passes [`MAX_WORK`]. The polygon need not be flat. Corners may repeat, as along a
/// bridge to a hole.
pub(super) fn cut(corners: &[Point3<f64>], work: &mut usize) -> Option<Vec<[u32; 3]>> {
    *work += corners.len();
    let normal = newell(corners);
    let least = -TURNED * normal.norm_squared();
    let first = corners.first()?;
    let mut parts = corners
        .windows(2)
        .map(|side| (side[0] - first).cross(&(side[1] - first)));
    match parts.any(|part| part.dot(&normal) < least) {
        true => clip(&flattened(corners, &normal), work),
        false => None,
    }
}

/// The area vector of a polygon by Newell's formula: along its normal, twice its area long.
fn newell(corners: &[Point3<f64>]) -> Vector3<f64> {
    let Some(first) = corners.first() else {
        return Vector3::zeros();
    };
    let sides = corners.windows(2);
    sides
        .map(|side| (side[0] - first).cross(&(side[1] - first)))
        .sum()
}

/// The polygon seen along the axis that its normal is closest to, from the side on which it runs counter-clockwise.
fn flattened(corners: &[Point3<f64>], normal: &Vector3<f64>) -> Vec<Point2<f64>> {
    let along = normal.iamax();
    let (x, y) = match normal[along] > 0.0 {
        true => ((along + 1) % 3, (along + 2) % 3),
        false => ((along + 2) % 3, (along + 1) % 3),
    };
    let first = corners[0];
    let flat = |corner: &Point3<f64>| Point2::new(corner[x] - first[x], corner[y] - first[y]);
    corners.iter().map(flat).collect()
}

/// Twice the signed area.
fn area(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

fn clip(outline: &[Point2<f64>], work: &mut usize) -> Option<Vec<[u32; 3]>> {
    let mut left: Vec<u32> = (0..outline.len() as u32).collect();
    let mut triangles = Vec::with_capacity(outline.len().saturating_sub(2));
    let at = |index: u32| &outline[index as usize];
    let mut start = 0;
    while left.len() > 3 {
        let count = left.len();
        let around = |i: usize| {
            [
                left[(i + count - 1) % count],
                left[i % count],
                left[(i + 1) % count],
            ]
        };
        let reflex: Vec<u32> = (0..count)
            .map(around)
            .filter(|&[a, b, c]| area(at(a), at(b), at(c)) <= 0.0)
            .map(|[_, b, _]| b)
            .collect();
        *work += count;
        let mut is_ear = |i: usize| {
            if *work > MAX_WORK {
                return false;
            }
            *work += reflex.len() + 1;
            let corners = around(i);
            let [a, b, c] = corners.map(at);
            // A corner on a straight side is cut off as a triangle without area.
            let flat = area(a, b, c) == 0.0 && (a - b).dot(&(c - b)) <= 0.0;
            flat || (area(a, b, c) > 0.0
                && !reflex.iter().any(|&other| is_inside(at(other), [a, b, c])))
        };
        let ear = (start..start + count).find(|&i| is_ear(i))? % count;
        triangles.push(around(ear));
        left.remove(ear);
        // Going on behind the ear, rather than at the same place, makes fewer slivers.
        start = ear + 1;
    }
    triangles.push([left[0], left[1], left[2]]);
    Some(triangles)
}

/// Whether a point is in a triangle or on its rim, but at none of its corners.
fn is_inside(point: &Point2<f64>, [a, b, c]: [&Point2<f64>; 3]) -> bool {
    [a, b, c].into_iter().all(|corner| corner != point)
        && area(a, b, point) >= 0.0
        && area(b, c, point) >= 0.0
        && area(c, a, point) >= 0.0
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    fn shape(corners: &[[f64; 2]]) -> Vec<Point3<f64>> {
        let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.3);
        let at = |&[x, y]: &[f64; 2]| turn * Point3::new(x, y, 0.0) + Vector3::new(5.0, 6.0, 7.0);
        corners.iter().map(at).collect()
    }

    /// Every triangle is wound like the outline, and together they have its area: nothing is covered twice.
    fn assert_covered(corners: &[Point3<f64>]) {
        let count = corners.len();
        for shift in 0..count {
            let mut turned = corners.to_vec();
            turned.rotate_left(shift);
            let normal = newell(&turned);
            let fan = || (2..count as u32).map(|i| [0, i - 1, i]).collect();
            let triangles = cut(&turned, &mut 0).unwrap_or_else(fan);
            assert_eq!(triangles.len(), count - 2);
            let mut sum = 0.0;
            for triangle in triangles {
                let [a, b, c] = triangle.map(|i| turned[i as usize]);
                let part = (b - a).cross(&(c - a)).dot(&normal) / normal.norm();
                assert!(part > -1e-12 * normal.norm(), "{part} of {}", normal.norm());
                sum += part;
            }
            assert!((sum / normal.norm() - 1.0).abs() < 1e-12, "{shift}");
        }
    }

    #[test]
    fn shapes_of_all_kinds_are_covered_once() {
        let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]];
        let l_shape = [
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        // A square with a square hole, joined by a bridge that runs both ways.
        let frame = [
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ];
        let comb: Vec<[f64; 2]> = [[20.0, -1.0], [20.0, 0.0]]
            .into_iter()
            .chain(
                (1..40)
                    .rev()
                    .map(|i| [f64::from(i) / 2.0, f64::from(i % 2) * 5.0]),
            )
            .chain([[0.0, 0.0], [0.0, -1.0]])
            .collect();
        let spiral: Vec<[f64; 2]> = (0..60)
            .map(|i| (f64::from(i) * 0.3, 1.0))
            .chain((0..60).rev().map(|i| (f64::from(i) * 0.3, 1.4)))
            .map(|(angle, width)| {
                let radius = width * (1.0 + angle / 5.0);
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        for corners in [&arrow[..], &l_shape, &frame, &comb, &spiral] {
            assert_covered(&shape(corners));
        }
    }

    #[test]
    fn random_stars_are_covered_once() {
        let mut state = 7_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / (1_u64 << 24) as f64
        };
        for count in 4..40 {
            let corners: Vec<[f64; 2]> = (0..count)
                .map(|i| {
                    let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
                    let radius = 0.1 + random();
                    [radius * angle.cos(), radius * angle.sin()]
                })
                .collect();
            assert_covered(&shape(&corners));
        }
    }

    #[test]
    fn corners_on_straight_sides_are_kept() {
        let corners = [
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
            [0.0, 1.0],
        ];
        assert_covered(&corners.map(|[x, y]| Point3::new(x, y, 0.0)));
    }

    #[test]
    fn work_is_counted_and_bounded() {
        let comb: Vec<Point3<f64>> = (0..2000)
            .map(|i| Point3::new(f64::from(i), f64::from(i % 2) * 9.0, 0.0))
            .chain([Point3::new(2000.0, -1.0, 0.0), Point3::new(0.0, -1.0, 0.0)])
            .collect();
        let mut work = 0;
        assert!(cut(&comb, &mut work).is_some());
        assert!(work > comb.len() * comb.len() / 4, "{work}");
        work = MAX_WORK - 5000;
        assert_eq!(cut(&comb, &mut work), None);
        assert!(work > MAX_WORK && work < MAX_WORK + 5000);
    }

    #[test]
    fn what_has_no_inside_ends_all_the_same() {
        let star = [0, 2, 4, 1, 3].map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 5.0;
            [angle.cos(), angle.sin()]
        });
        assert!(cut(&shape(&star), &mut 0).is_none_or(|triangles| triangles.len() == 3));
        assert_eq!(cut(&[], &mut 0), None);
        assert_eq!(cut(&shape(&[[1.0, 1.0]; 5]), &mut 0), None);
    }
}
