//! Whether single precision is fine enough for the body in a file.
//!
//! A single-precision number has 24 binary digits, so its step grows with its size: it is 1 between 8 and 16 million. A
//! body that is small beside its distance from the origin is rounded to that step, and its small triangles collapse.

use nalgebra::{Point3, Vector3};

/// The greatest step, as a share of the diagonal of the body, that goes without a warning. A facet of a hundredth of
/// the diagonal then has corners that are off by at most half a hundredth of its length, and a normal that is off by
/// about half a degree.
const MAX_STEP: f64 = 1e-4;

/// The bounding box of the positions that a file has in single precision.
#[derive(Default)]
pub(super) struct SinglePrecision(Option<[Point3<f64>; 2]>);

impl SinglePrecision {
    /// Takes a position into account.
    pub(super) fn add(&mut self, position: [f64; 3]) {
        let position = Point3::from(position);
        let [low, high] = self.0.get_or_insert([position; 2]);
        *low = low.inf(&position);
        *high = high.sup(&position);
    }

    /// Returns a warning when the step of the coordinates is coarse for the body.
    pub(super) fn doubt(&self) -> Option<String> {
        let [low, high] = self.0?;
        let size = (high - low).norm();
        let greatest = Vector3::from(low.coords.abs())
            .sup(&high.coords.abs())
            .max();
        let step = step(greatest);
        (step > MAX_STEP * size).then(|| {
            format!(
                "the coordinates are in single precision and reach {greatest:.3e}, where they come in steps of {step:.3e}, \
                 but the body measures only {size:.3e}: its shape is rounded, and small triangles are lost; move the \
                 body to the origin before you export it, or export a format with more digits, such as OBJ"
            )
        })
    }
}

/// The distance between a single-precision number and the next greater one.
fn step(x: f64) -> f64 {
    let x = x.abs() as f32;
    f64::from(f32::from_bits(x.to_bits() + 1)) - f64::from(x)
}
