//! The sizes of the marks of a grasp, in pictures and exports.

use nalgebra::{Unit, UnitVector3, Vector3};

/// Length of an arrow that ends in a contact, in radii of the body.
pub const ARROW: f64 = 0.45;
/// Slant height of a friction cone, in radii of the body.
pub const CONE: f64 = 0.3;
/// Length of the arrow of a weakest force of size one, in radii of the body.
pub const WEAKEST: f64 = 0.6;
/// Radius of the bent arrow of the weakest torque, in radii of the body.
pub const BENT: f64 = 0.3;
/// Share of the weakest wrench below which its force or torque is not shown.
pub const NEGLIGIBLE: f64 = 1e-3;

/// Returns the height of a friction cone of the given slant height, and the tangent of half its apex angle.
pub fn cone(friction: f64, slant: f64) -> (f64, f64) {
    (slant / friction.hypot(1.0), friction)
}

/// Returns a unit vector perpendicular to another, always the same one.
pub fn perpendicular(axis: &UnitVector3<f64>) -> UnitVector3<f64> {
    let least = axis.iamin();
    Unit::new_normalize(Vector3::ith(least, 1.0).cross(axis))
}
