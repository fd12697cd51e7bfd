//! All grasps of a small problem, one after the other.

use super::problem::{Grasp, GraspEvaluator, Problem};
use crate::interrupt::{Interrupt, Interrupted};

/// Most grasps that are looked at.
const MOST: u64 = 20_000;

/// Most wrenches of all of them together; some 0.1 s.
const MOST_WRENCHES: u64 = 1 << 19;

/// All grasps of a problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Exhaustion {
    /// How many there are.
    pub grasps: u64,
    /// The best and its ε; `None` when no choice of candidates is force closure.
    pub best: Option<(Grasp, f64)>,
}

/// Looks at all grasps there are, where these are few and within the limit of evaluations; `None` otherwise, and
/// where some hull could not be finished, so that nothing is known of its grasp. `interrupt` is checked before each.
pub fn exhaust(
    problem: &Problem,
    evaluation_limit: Option<u64>,
    evaluations: &mut u64,
    interrupt: Interrupt<'_>,
) -> Result<Option<Exhaustion>, Interrupted> {
    let (n, m) = (problem.len(), problem.contacts());
    let count = (0..m as u64).try_fold(1_u64, |count, i| {
        // C(n, i + 1) from C(n, i); the division is exact.
        let count = count.checked_mul(n as u64 - i)? / (i + 1);
        (count <= MOST || 2 * (i + 1) < n as u64).then_some(count)
    });
    let effort = if problem.model().is_finite_hull() {
        1
    } else {
        64
    };
    let most = (MOST_WRENCHES / (effort * problem.wrenches_per_grasp() as u64)).min(MOST);
    let left = evaluation_limit.map_or(u64::MAX, |limit| limit.saturating_sub(*evaluations));
    let Some(count) = count.filter(|count| *count <= most.min(left)) else {
        return Ok(None);
    };
    let mut evaluator = GraspEvaluator::new(problem);
    let mut grasp: Grasp = (0..m as u32).collect();
    let mut best: Option<(Grasp, f64)> = None;
    for _ in 0..count {
        interrupt.check()?;
        *evaluations += 1;
        match evaluator.quality(&grasp) {
            _ if !problem.fits(&grasp) => {}
            Ok(margin) if problem.closes(&margin) => {
                if best.as_ref().is_none_or(|(_, most)| margin.value > *most) {
                    best = Some((grasp.clone(), margin.value));
                }
            }
            Ok(margin) if margin.upper > problem.closure_floor() => {
                return Ok(None);
            }
            Ok(_) | Err(_) => {}
        }
        advance(&mut grasp, n as u32);
    }
    Ok(Some(Exhaustion {
        grasps: count,
        best,
    }))
}

/// The next subset in lexicographic order.
fn advance(grasp: &mut [u32], n: u32) {
    let m = grasp.len();
    let Some(slot) = (0..m).rfind(|&slot| grasp[slot] < n - (m - slot) as u32) else {
        return;
    };
    grasp[slot] += 1;
    for later in slot + 1..m {
        grasp[later] = grasp[later - 1] + 1;
    }
}
