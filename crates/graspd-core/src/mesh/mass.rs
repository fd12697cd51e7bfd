//! Volume, centre of mass and flatness.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use parry3d_f64::mass_properties::details::trimesh_signed_volume_and_center_of_mass;
use parry3d_f64::math::Vector;

use super::triangle;

/// Steps after which the search for principal axes gives up; three by three needs a handful.
const MAX_SWEEPS: usize = 100;

/// Mass properties of a solid of uniform density.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solid {
    pub(super) volume: f64,
    /// Of mass.
    pub(super) center: Point3<f64>,
    /// How far the volumes along the three axes are from `volume`, over it.
    pub(super) error: f64,
}

/// Enclosed volume and centre of mass of a closed, outward surface at uniform density.
///
/// Signed tetrahedra about the centre of the box, in units of its diagonal: a body far from the
/// origin loses no precision and one of extreme size neither overflows nor vanishes. The volume is checked
/// by the flux of x, y and z through the surface, three sums that agree with it only when that is closed.
pub(super) fn solid(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    center: &Point3<f64>,
    diagonal: f64,
) -> Solid {
    let local: Vec<Vector> = vertices
        .iter()
        .map(|v| (v - center) / diagonal)
        .map(|v| Vector::new(v.x, v.y, v.z))
        .collect();
    let (volume, at) = trimesh_signed_volume_and_center_of_mass(&local, triangles);
    let flux: Vector3<f64> = triangles
        .iter()
        .map(|&indices| triangle::corners(vertices, indices))
        .map(|corners| corners.map(|corner| Point3::from((corner - center) / diagonal)))
        .map(|corners| {
            let middle = triangle::centroid(&corners).coords;
            middle.component_mul(&triangle::normal(&corners)) / 2.0
        })
        .sum();
    Solid {
        volume: volume * diagonal.powi(3),
        center: center + Vector3::new(at.x, at.y, at.z) * diagonal,
        error: (flux / volume).add_scalar(-1.0).amax(),
    }
}

/// Total area, and the centre of mass of the surface as a thin shell of uniform thickness.
pub(super) fn surface(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    center: &Point3<f64>,
) -> (f64, Point3<f64>) {
    let (area, moment) = triangles
        .iter()
        .map(|&indices| triangle::corners(vertices, indices))
        .fold((0.0, Vector3::zeros()), |(area, moment), corners| {
            let share = triangle::area(&corners);
            let arm = triangle::centroid(&corners) - center;
            (area + share, moment + arm * share)
        });
    (area, center + moment / area)
}

/// Distance between the two closest parallel planes, at right angles to a principal axis, that
/// hold all vertices between them.
///
/// For points of one plane this is zero but for rounding, in whatever direction the plane lies.
pub(super) fn thickness(vertices: &[Point3<f64>], center: &Point3<f64>, diagonal: f64) -> f64 {
    let local = || vertices.iter().map(|v| (v - center) / diagonal);
    let mean = local().sum::<Vector3<f64>>() / vertices.len() as f64;
    let covariance: Matrix3<f64> = local().map(|v| (v - mean) * (v - mean).transpose()).sum();
    let axes = SymmetricEigen::try_new(covariance, f64::EPSILON, MAX_SWEEPS)
        .map_or_else(Matrix3::identity, |eigen| eigen.eigenvectors);
    let widths = axes.column_iter().map(|axis| {
        let (low, high) = local()
            .map(|v| axis.dot(&v))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
        high - low
    });
    widths.fold(f64::INFINITY, f64::min) * diagonal
}

/// Greatest distance of a vertex from `point`.
pub(super) fn radius_about(vertices: &[Point3<f64>], point: &Point3<f64>) -> f64 {
    vertices
        .iter()
        .map(|v| (v - point).norm_squared())
        .fold(0.0, f64::max)
        .sqrt()
}
