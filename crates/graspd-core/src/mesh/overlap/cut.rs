//! A triangle, cut where others meet it.
//!
//! ```text
//! pieces = { the triangle }
//! for each stretch along which another triangle meets it:
//!     for each piece that the stretch runs through:
//!         cut the piece along the line of the stretch
//! ```
//!
//! **Invariant:** the pieces are convex, and cover the triangle without overlap. At the end no stretch runs through the
//! inside of a piece, so a piece is on one side of every other surface as a whole. A cut goes through the whole piece,
//! also where its stretch ends within it; that makes more pieces than there must be, and does no harm.
//!
//! **Cost:** stretches times pieces. A triangle with so many of both that this passes [`MAX_WORK`] is left cut as far as
//! it is, and said to be unfinished.

use nalgebra::{Point3, Vector2, Vector3};

use crate::mesh::triangle;

/// Most pieces that are compared with stretches for one triangle; some hundredths of a second.
const MAX_WORK: usize = 1 << 20;

/// A convex polygon in the plane of a triangle.
pub(super) type Polygon = Vec<Vector2<f64>>;

/// Coordinates in the plane of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    origin: Point3<f64>,
    axes: [Vector3<f64>; 2],
}

impl Plane {
    /// The plane of a triangle that is not degenerate.
    pub(super) fn of(corners: &[Point3<f64>; 3]) -> Self {
        let first = (corners[1] - corners[0]).normalize();
        let normal = triangle::normal(corners).normalize();
        Self {
            origin: corners[0],
            axes: [first, normal.cross(&first)],
        }
    }

    pub(super) fn flat(&self, point: &Point3<f64>) -> Vector2<f64> {
        let arm = point - self.origin;
        Vector2::new(arm.dot(&self.axes[0]), arm.dot(&self.axes[1]))
    }

    pub(super) fn point(&self, flat: &Vector2<f64>) -> Point3<f64> {
        self.origin + self.axes[0] * flat.x + self.axes[1] * flat.y
    }
}

/// A triangle in pieces.
#[derive(Debug)]
pub(super) struct Pieces {
    pub(super) plane: Plane,
    pub(super) polygons: Vec<Polygon>,
    /// Length of all cuts.
    pub(super) cut: f64,
    /// Whether every stretch was taken into account.
    pub(super) finished: bool,
}

/// Cuts a triangle along stretches that lie in its plane within `tolerance`.
pub(super) fn cut(
    corners: &[Point3<f64>; 3],
    stretches: &[[Point3<f64>; 2]],
    tolerance: f64,
) -> Pieces {
    let plane = Plane::of(corners);
    let mut pieces = Pieces {
        plane,
        polygons: vec![corners.iter().map(|corner| plane.flat(corner)).collect()],
        cut: 0.0,
        finished: true,
    };
    let mut work = 0;
    for stretch in stretches {
        let [from, to] = stretch.each_ref().map(|point| plane.flat(point));
        let Some(along) = (to - from).try_normalize(tolerance) else {
            continue;
        };
        work += pieces.polygons.len();
        if work > MAX_WORK {
            pieces.finished = false;
            break;
        }
        for n in 0..pieces.polygons.len() {
            let inside = clipped(&pieces.polygons[n], &from, &to);
            if inside > tolerance
                && let Some([left, right]) = halves(&pieces.polygons[n], &from, &along, tolerance)
            {
                pieces.cut += inside;
                pieces.polygons[n] = left;
                pieces.polygons.push(right);
            }
        }
    }
    pieces
}

fn cross(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Length of what a convex polygon, wound to the left, has of a stretch (Cyrus and Beck 1978).
fn clipped(polygon: &Polygon, from: &Vector2<f64>, to: &Vector2<f64>) -> f64 {
    let way = to - from;
    let (mut begin, mut end) = (0.0_f64, 1.0_f64);
    for (i, corner) in polygon.iter().enumerate() {
        let side = polygon[(i + 1) % polygon.len()] - corner;
        // How far inside the side the stretch begins, and how much farther it gets.
        let (inside, gain) = (cross(&side, &(from - corner)), cross(&side, &way));
        if gain > 0.0 {
            begin = begin.max(-inside / gain);
        } else if gain < 0.0 {
            end = end.min(-inside / gain);
        } else if inside < 0.0 {
            return 0.0;
        }
    }
    (end - begin).max(0.0) * way.norm()
}

/// The parts of a convex polygon on both sides of a line; `None` when one would be thinner than `tolerance`.
fn halves(
    polygon: &Polygon,
    on: &Vector2<f64>,
    along: &Vector2<f64>,
    tolerance: f64,
) -> Option<[Polygon; 2]> {
    let distances: Vec<f64> = polygon
        .iter()
        .map(|corner| cross(along, &(corner - on)))
        .collect();
    let (mut left, mut right) = (Vec::new(), Vec::new());
    let (mut most, mut least) = (0.0_f64, 0.0_f64);
    for (i, corner) in polygon.iter().enumerate() {
        let j = (i + 1) % polygon.len();
        let (here, next) = (distances[i], distances[j]);
        (most, least) = (most.max(here), least.min(here));
        if here >= 0.0 {
            left.push(*corner);
        }
        if here <= 0.0 {
            right.push(*corner);
        }
        if (here > 0.0 && next < 0.0) || (here < 0.0 && next > 0.0) {
            let at = corner + (polygon[j] - corner) * (here / (here - next));
            left.push(at);
            right.push(at);
        }
    }
    (most > tolerance && least < -tolerance).then_some([left, right])
}

/// The area of a polygon and its centroid.
pub(super) fn area_and_centroid(polygon: &Polygon) -> (f64, Vector2<f64>) {
    let first = polygon[0];
    let (mut area, mut moment) = (0.0, Vector2::zeros());
    for pair in polygon[1..].windows(2) {
        let (a, b) = (pair[0] - first, pair[1] - first);
        let part = cross(&a, &b) / 2.0;
        area += part;
        moment += (a + b) * (part / 3.0);
    }
    match area > 0.0 {
        true => (area, first + moment / area),
        false => (0.0, first),
    }
}

/// Distance of a point from the nearest side of a convex polygon, negative outside.
pub(super) fn inside(polygon: &Polygon, point: &Vector2<f64>) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let distance = |(a, b): (&Vector2<f64>, &Vector2<f64>)| {
        (b - a)
            .try_normalize(0.0)
            .map_or(f64::INFINITY, |side| cross(&side, &(point - a)))
    };
    polygon
        .iter()
        .zip(next)
        .map(distance)
        .fold(f64::INFINITY, f64::min)
}

/// The length of the outline of a polygon.
pub(super) fn perimeter(polygon: &Polygon) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(a, b)| (b - a).norm()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]];

    fn stretch(from: [f64; 2], to: [f64; 2]) -> [Point3<f64>; 2] {
        [from, to].map(|[x, y]| Point3::new(x, y, 1.0))
    }

    fn areas(stretches: &[[Point3<f64>; 2]]) -> Vec<f64> {
        let pieces = cut(&TRIANGLE.map(Point3::from), stretches, 1e-6);
        assert!(pieces.finished);
        let mut areas: Vec<f64> = pieces
            .polygons
            .iter()
            .map(|p| area_and_centroid(p).0)
            .collect();
        areas.sort_by(f64::total_cmp);
        assert!((areas.iter().sum::<f64>() - 8.0).abs() < 1e-12);
        areas
    }

    #[test]
    fn pieces_cover_the_triangle_and_no_stretch_runs_through_one() {
        assert_eq!(areas(&[]), [8.0]);
        assert_eq!(areas(&[stretch([1.0, -1.0], [1.0, 9.0])]), [3.5, 4.5]);
        // Along a side, beyond it, and too short to matter.
        for nothing in [
            stretch([0.0, 0.0], [4.0, 0.0]),
            stretch([5.0, 0.0], [5.0, 4.0]),
            stretch([1.0, 1.0], [1.0, 1.0]),
        ] {
            assert_eq!(areas(&[nothing]), [8.0]);
        }
        // The outline of a square within.
        let square = [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [0.5, 1.5]];
        let outline: Vec<_> = (0..4)
            .map(|i| stretch(square[i], square[(i + 1) % 4]))
            .collect();
        let found = areas(&outline);
        assert!(
            found.iter().any(|area| (area - 1.0).abs() < 1e-12),
            "{found:?}"
        );
    }
}
