//! Points in an order in which those that follow on one another are neighbours.

use nalgebra::Point3;
use rayon::prelude::*;

use super::BLOCK;
use crate::interrupt::{Interrupt, Interrupted};

/// Steps along each axis, less one.
const STEPS: f64 = 1023.0;

/// The numbers below `count` in the order of their positions along a Z-order curve (Morton 1966) with 2¹⁰
/// steps an axis; in their own order where positions share a step.
///
/// O(n log n) on the current rayon pool; `interrupt` is checked every few milliseconds.
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
            // The cast takes no number for zero.
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

/// Ten bits with two zeros after each.
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
