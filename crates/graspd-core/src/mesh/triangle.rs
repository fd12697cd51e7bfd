//! The geometry of one triangle.

use nalgebra::{Point3, Vector3};

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
