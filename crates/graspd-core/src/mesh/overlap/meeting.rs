//! Where two triangles meet.
//!
//! The plane of each triangle cuts the other along a chord. Both chords lie on the line in which the planes meet, and
//! the triangles meet where the chords overlap. Everything within the tolerance of a plane counts as in it, so that
//! walls which touch meet as surely as walls which cross.
//!
//! ```text
//! distances of the corners of each triangle from the plane of the other
//! all within the tolerance:        one plane; they meet unless a side of one separates them
//! all on one side:                 they do not meet
//! else:                            they meet in the common stretch of the two chords
//! ```

use nalgebra::Point3;

use crate::mesh::triangle;

/// How two triangles meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Meeting {
    /// Along a stretch, which may be a point.
    Stretch([Point3<f64>; 2]),
    /// In a common plane.
    Plane,
}

/// Where two triangles that are not degenerate meet, or come as close as `tolerance`. In one plane they do if no side
/// separates them by more than `gap`, which may be negative to ask for an overlap.
pub(super) fn meeting(
    one: &[Point3<f64>; 3],
    other: &[Point3<f64>; 3],
    tolerance: f64,
    gap: f64,
) -> Option<Meeting> {
    let from_one = distances(one, other);
    let (low, high) = span(&from_one);
    if low > tolerance || high < -tolerance {
        return None;
    }
    let from_other = distances(other, one);
    let (below, above) = span(&from_other);
    if below > tolerance || above < -tolerance {
        return None;
    }
    let flat = |low: f64, high: f64| -tolerance <= low && high <= tolerance;
    if flat(low, high) || flat(below, above) {
        let apart = separates(one, other, gap) || separates(other, one, gap);
        return (!apart).then_some(Meeting::Plane);
    }
    let mut chords = [
        chord(other, &from_one, tolerance)?,
        chord(one, &from_other, tolerance)?,
    ];
    let length = |[a, b]: &[Point3<f64>; 2]| (b - a).norm();
    if length(&chords[0]) < length(&chords[1]) {
        chords.swap(0, 1);
    }
    let [[from, to], shorter] = chords;
    let Some(along) = (to - from).try_normalize(tolerance) else {
        let near = (shorter[0] - from).norm() <= 2.0 * tolerance;
        return near.then_some(Meeting::Stretch([from, from]));
    };
    let [a, b] = shorter.map(|point| (point - from).dot(&along));
    let (begin, end) = (a.min(b).max(0.0), a.max(b).min((to - from).norm()));
    (begin <= end + tolerance)
        .then(|| Meeting::Stretch([begin, end.max(begin)].map(|share| from + along * share)))
}

/// Distances of the corners of `other` from the plane of `triangle`.
fn distances(corners: &[Point3<f64>; 3], other: &[Point3<f64>; 3]) -> [f64; 3] {
    let normal = triangle::normal(corners).normalize();
    other.map(|corner| normal.dot(&(corner - corners[0])))
}

fn span(values: &[f64; 3]) -> (f64, f64) {
    let [a, b, c] = *values;
    (a.min(b).min(c), a.max(b).max(c))
}

/// What a plane cuts out of a triangle whose corners are at these distances from it.
fn chord(
    corners: &[Point3<f64>; 3],
    distances: &[f64; 3],
    tolerance: f64,
) -> Option<[Point3<f64>; 2]> {
    let mut points: [Option<Point3<f64>>; 3] = [None; 3];
    let mut found = 0;
    let mut add = |point: Point3<f64>| {
        if let Some(place) = points.get_mut(found) {
            *place = Some(point);
            found += 1;
        }
    };
    for i in 0..3 {
        let (j, at, next) = ((i + 1) % 3, distances[i], distances[(i + 1) % 3]);
        if at.abs() <= tolerance {
            add(corners[i]);
        } else if next.abs() > tolerance && (at < 0.0) != (next < 0.0) {
            add(corners[i] + (corners[j] - corners[i]) * (at / (at - next)));
        }
    }
    let first = points[0]?;
    Some([first, points[1].unwrap_or(first)])
}

/// Whether a side of `one` has all of `other`, in the same plane, more than `gap` beyond it.
fn separates(one: &[Point3<f64>; 3], other: &[Point3<f64>; 3], gap: f64) -> bool {
    let normal = triangle::normal(one);
    (0..3).any(|i| {
        let along = one[(i + 1) % 3] - one[i];
        let outward = along.cross(&normal).normalize();
        other
            .iter()
            .all(|corner| outward.dot(&(corner - one[i])) > gap)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f64; 3]; 3]) -> [Point3<f64>; 3] {
        corners.map(Point3::from)
    }

    #[test]
    fn triangles_meet_where_they_should() {
        let floor = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let wall = |x: f64, from: f64, low: f64| {
            triangle([[x, from, low], [x, from + 2.0, low], [x, from, low + 3.0]])
        };
        let stretch = |other: [Point3<f64>; 3]| {
            let there = meeting(&floor, &other, 1e-6, 1e-6);
            let back = meeting(&other, &floor, 1e-6, 1e-6);
            let Some(Meeting::Stretch([a, b])) = there else {
                assert_eq!((there, back), (None, None));
                return None;
            };
            assert!(matches!(back, Some(Meeting::Stretch(_))));
            Some((a.y.min(b.y), a.y.max(b.y)))
        };
        // Through the floor, with a third of its height below; and standing on it.
        let (low, high) = stretch(wall(1.0, 1.0, -1.0)).unwrap();
        assert!((low - 1.0).abs() < 1e-12 && (high - 7.0 / 3.0).abs() < 1e-12);
        assert_eq!(stretch(wall(1.0, 0.5, 0.0)), Some((0.5, 2.5)));
        // Beyond the long side of the floor, and above it.
        let (low, high) = stretch(wall(3.0, 0.0, 0.0)).unwrap();
        assert!(low.abs() < 1e-12 && (high - 1.0).abs() < 1e-12);
        assert_eq!(stretch(wall(3.0, 1.5, -1.0)), None);
        assert_eq!(stretch(wall(1.0, 1.0, 1e-3)), None);
        // In the same plane, on it and beside it.
        let shifted = |by: f64| floor.map(|p| p + nalgebra::Vector3::new(by, by, 0.0));
        assert_eq!(
            meeting(&floor, &shifted(1.0), 1e-6, 1e-6),
            Some(Meeting::Plane)
        );
        assert_eq!(meeting(&floor, &shifted(2.1), 1e-6, 1e-6), None);
    }
}
