//! Points in an order in which those that follow one another are near each other.
//!
//! Boxes and balls about blocks of consecutive points are small only if the points are near each other. A curve that
//! fills space gives such an order in one sort: the box of the points is cut into 2¹⁰ steps along each axis, and the
//! bits of the three step numbers are interleaved to one number, the place along a Z-order curve (Morton 1966).
//!
//! ```text
//! x = 5 = 101₂, y = 3 = 011₂, z = 6 = 110₂    code = z₂y₂x₂ z₁y₁x₁ z₀y₀x₀ = 101 110 011₂
//! ```
//!
//! Points with the highest bits in common are in the same eighth of the box, those with the next bits too in the same
//! eighth of that, and so on. The curve jumps now and then, so some blocks are larger than they must be; a Hilbert
//! curve would not, but costs more than it saves here.
//!
//! **Cost:** O(n log n) on the current rayon pool. Ties are in the order of the points, so the result is the same on any
//! number of threads.

use nalgebra::Point3;
use rayon::prelude::*;

use super::BLOCK;
use crate::interrupt::{Interrupt, Interrupted};

/// The greatest step number along an axis.
const STEPS: f64 = 1023.0;

/// The numbers below `count` in the order of their positions along the curve; in their own order where positions
/// share a cell. `interrupt` is checked every few milliseconds.
pub(crate) fn along_curve(
    count: usize,
    position: impl Fn(usize) -> Point3<f64> + Sync,
    interrupt: Interrupt<'_>,
) -> Result<Vec<u32>, Interrupted> {
    interrupt.check()?;
    let mut low = Point3::from([f64::INFINITY; 3]);
    let mut high = Point3::from([f64::NEG_INFINITY; 3]);
    for point in (0..count).map(&position) {
        (low, high) = (low.inf(&point), high.sup(&point));
    }
    let code = |point: Point3<f64>| {
        (0..3).fold(0_u64, |code, axis| {
            let share = (point[axis] - low[axis]) / (high[axis] - low[axis]);
            // Along an axis without extent the share is not a number, of which the cast makes 0.
            code | spaced((share * STEPS) as u64) << axis
        })
    };
    let mut order: Vec<(u64, u32)> = Vec::with_capacity(count);
    for from in (0..count).step_by(BLOCK) {
        interrupt.check()?;
        let block = (from..count.min(from + BLOCK)).into_par_iter();
        order.par_extend(block.map(|i| (code(position(i)), i as u32)));
    }
    interrupt.check()?;
    order.par_sort_unstable();
    Ok(order.into_iter().map(|(_, i)| i).collect())
}

/// Ten bits, spread so that two zeros follow each.
fn spaced(bits: u64) -> u64 {
    (0..10).fold(0, |spaced, bit| spaced | (bits >> bit & 1) << (3 * bit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interrupt::{at_check, uninterrupted};

    #[test]
    fn corners_of_a_box_come_in_their_order_and_equals_in_theirs() {
        let corner = |i: usize| {
            let bit = |axis: usize| ((i >> axis) & 1) as f64;
            Point3::new(3.0 * bit(0), bit(1) - 7.0, 0.1 * bit(2))
        };
        let order = uninterrupted(|interrupt| along_curve(16, corner, interrupt));
        let expected: Vec<u32> = (0..8).flat_map(|i| [i, i + 8]).collect();
        assert_eq!(order, expected);
        let one_place = |_| Point3::origin();
        assert_eq!(
            uninterrupted(|interrupt| along_curve(3, one_place, interrupt)),
            [0, 1, 2]
        );
    }

    #[test]
    fn it_can_be_broken_off() {
        let position = |i: usize| Point3::new(i as f64, 0.0, 0.0);
        for check in 1..=5 {
            let ask = at_check(check);
            assert_eq!(
                along_curve(3 * BLOCK, position, Interrupt::new(&ask)),
                Err(Interrupted::Cancelled)
            );
        }
        let ask = at_check(6);
        assert!(along_curve(3 * BLOCK, position, Interrupt::new(&ask)).is_ok());
    }
}
