//! The geometry of one triangle.

use nalgebra::{Point3, Vector3};

/// The weights of the corners at the centroid.
pub(super) const CENTROID: [f64; 3] = [1.0 / 3.0; 3];

/// The corners of a triangle.
pub(super) fn corners(vertices: &[Point3<f64>], triangle: [u32; 3]) -> [Point3<f64>; 3] {
    triangle.map(|index| vertices[index as usize])
}

/// Twice the area, along the normal that the winding gives.
pub(super) fn normal([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Half the length of the [normal].
pub(super) fn area(corners: &[Point3<f64>; 3]) -> f64 {
    normal(corners).norm() / 2.0
}

/// The centroid, computed from the first corner so that a triangle far from the origin loses no precision.
pub(super) fn centroid([a, b, c]: &[Point3<f64>; 3]) -> Point3<f64> {
    a + ((b - a) + (c - a)) / 3.0
}

/// Whether the triangle is a line or a point: its least height is no more than `tolerance`.
///
/// Points closer than the welding tolerance are one point, so a triangle thinner than that has
/// no normal worth the name.
pub(super) fn is_degenerate(corners: &[Point3<f64>; 3], tolerance: f64) -> bool {
    let [a, b, c] = corners;
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    normal(corners).norm() <= longest * tolerance
}

/// Signed volume of the tetrahedron from `apex`: positive when the winding is outward seen
/// from there.
pub(super) fn volume([a, b, c]: &[Point3<f64>; 3], apex: &Point3<f64>) -> f64 {
    (a - apex).dot(&(b - apex).cross(&(c - apex))) / 6.0
}

/// Weights of the corners at a point in the plane of a triangle; negative ones outside.
pub(super) fn raw_barycentric(corners: &[Point3<f64>; 3], point: &Point3<f64>) -> [f64; 3] {
    let [a, b, c] = corners;
    let whole = normal(corners);
    let share = |u: &Point3<f64>, v: &Point3<f64>| {
        (u - point).cross(&(v - point)).dot(&whole) / whole.norm_squared()
    };
    [share(b, c), share(c, a), share(a, b)]
}

/// The same, clamped to the triangle.
pub(super) fn barycentric(corners: &[Point3<f64>; 3], point: &Point3<f64>) -> [f64; 3] {
    normalized(raw_barycentric(corners, point))
}

/// Weights that rounding has moved, at least zero and with sum one again.
pub(super) fn normalized(weights: [f64; 3]) -> [f64; 3] {
    let weights = weights.map(|weight| weight.max(0.0));
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| (weight / sum).min(1.0))
}
