//! Exhaustive search: all grasps of a small problem.
//!
//! A search that found nothing says nothing about grasps that it did not try. Where C(n, m) is small all are
//! evaluated, in lexicographic order, and the answer is final: the best grasp, or the proof that no choice of
//! candidates is force closure.
//!
//! A grasp whose hull could not be finished leaves its ε open between two bounds. If the upper one is above the
//! closure floor nothing is proven, and the search returns nothing. It costs C(n, m) evaluations, bounded by
//! [`MOST`] and [`MOST_WRENCHES`], some 0.1 s.

use super::evaluator::GraspEvaluator;
use super::problem::{Grasp, SearchProblem};
use super::progress::Budget;
use crate::interrupt::{Interrupt, Interrupted};

/// Most grasps that are evaluated.
const MOST: u64 = 20_000;

/// Most wrenches of all of them together; some 0.1 s.
const MOST_WRENCHES: u64 = 1 << 19;

/// Evaluations of a finite hull that take the time of one where cones are round or the space is L∞.
const CURVED_COST: u64 = 64;

/// What an exhaustive search found.
#[derive(Debug, Clone, PartialEq)]
pub struct AllGrasps {
    /// How many grasps there are.
    pub grasps: u64,
    /// The best and its ε; `None` when no choice of candidates is force closure.
    pub best: Option<(Grasp, f64)>,
}

/// Evaluates all grasps of a problem, where these are few and within the budget; `None` otherwise, and where some
/// hull could not be finished, so that nothing is known of its grasp. `interrupt` is checked before each.
pub fn exhaustive_search(
    problem: &SearchProblem,
    budget: &mut Budget,
    interrupt: Interrupt<'_>,
) -> Result<Option<AllGrasps>, Interrupted> {
    let (n, m) = (problem.len(), problem.contacts());
    let cost = if problem.model().is_finite_hull() {
        1
    } else {
        CURVED_COST
    };
    let most = (MOST_WRENCHES / (cost * problem.wrenches_per_grasp() as u64)).min(MOST);
    let count = subsets(n as u64, m as u64).filter(|count| *count <= most.min(budget.left()));
    let Some(count) = count else {
        return Ok(None);
    };
    let mut evaluator = GraspEvaluator::new(problem);
    let mut grasp: Grasp = (0..m as u32).collect();
    let mut best: Option<(Grasp, f64)> = None;
    for _ in 0..count {
        interrupt.check()?;
        budget.spend(1);
        match evaluator.quality(&grasp) {
            _ if !problem.keeps_spacing(&grasp) => {}
            Ok(margin) if problem.passes_closure_floor(&margin) => {
                if best.as_ref().is_none_or(|(_, most)| margin.value > *most) {
                    best = Some((grasp.clone(), margin.value));
                }
            }
            // It may be force closure or not.
            Ok(margin) if margin.upper > problem.closure_floor() => {
                return Ok(None);
            }
            Ok(_) | Err(_) => {}
        }
        advance(&mut grasp, n as u32);
    }
    Ok(Some(AllGrasps {
        grasps: count,
        best,
    }))
}

/// Returns C(n, m), the number of subsets; `None` when it overflows or is beyond [`MOST`] on the way.
fn subsets(n: u64, m: u64) -> Option<u64> {
    (0..m).try_fold(1_u64, |count, i| {
        // C(n, i + 1) from C(n, i); the division is exact.
        let count = count.checked_mul(n - i)? / (i + 1);
        // Past the middle of the row the numbers fall again. One that is too large there ends the count: its
        // grasps have so many contacts that it is not worth going on.
        (count <= MOST || 2 * (i + 1) < n).then_some(count)
    })
}

/// Moves on to the next subset in lexicographic order.
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
