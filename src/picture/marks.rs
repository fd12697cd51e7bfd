//! How large the marks of a grasp are, in pictures and exports alike.

use nalgebra::{Unit, UnitVector3, Vector3};

/// Length of an arrow that ends in a contact, over the radius of the body.
pub const ARROW: f64 = 0.45;
/// Slant of a friction cone, over the radius of the body.
pub const CONE: f64 = 0.3;
/// Length of the arrow of a weakest force of one, over the radius of the body.
pub const WEAKEST: f64 = 0.6;
/// Radius of the bend of the weakest torque, over the radius of the body.
pub const BENT: f64 = 0.3;
/// Shares of the weakest wrench below which force or torque are not shown.
pub const NEGLIGIBLE: f64 = 1e-3;

/// Height, and tangent of half the angle at the apex, of a friction cone of some slant.
pub fn cone(friction: f64, slant: f64) -> (f64, f64) {
    (slant / friction.hypot(1.0), friction)
}

/// A unit vector across another, always the same.
pub fn perpendicular(axis: &UnitVector3<f64>) -> UnitVector3<f64> {
    let least = axis.iamin();
    Unit::new_normalize(Vector3::ith(least, 1.0).cross(axis))
}
