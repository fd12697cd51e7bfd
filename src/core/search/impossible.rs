//! Proof that a body cannot be held, whatever candidates are chosen.

use super::problem::Problem;
use super::random::{Purpose, Stream};
use crate::core::contact::ContactModel;
use crate::core::quality::{CLOSURE_TOLERANCE, Evaluator, RANK_TOLERANCE};
use crate::core::wrench::Wrench;

/// Why no force-closure grasp exists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Impossible {
    /// That few contacts of this model never hold any body.
    TooFewContacts { least: usize },
    /// All wrenches of all candidates have the same component in this unit direction (zero when
    /// the body is symmetric about an axis and there is no friction). They span `rank` dimensions.
    Deficient { rank: usize, direction: Wrench },
    /// No wrench of any candidate has a positive component in this unit direction.
    OneSided { direction: Wrench },
}

/// Rounds of adding the wrench that contradicts the present hyperplane. Each takes one pass over
/// the candidates; a dozen are usual.
const ROUNDS: usize = 200;

/// The least number of contacts of the problem's model that can hold a body, when it asks for fewer:
/// less than 7 frictionless contacts span too few dimensions, and two hard ones resist no torque
/// about the line through them (Markenscoff et al. 1990).
pub fn too_few_contacts(problem: &Problem) -> Option<Impossible> {
    let least = match problem.model().contact_model {
        ContactModel::Frictionless => 7,
        ContactModel::Hard { .. } => 3,
    };
    (problem.contacts() < least).then_some(Impossible::TooFewContacts { least })
}

/// Looks for a proof that no set of candidates, of any number, is force closure.
///
/// A hyperplane with the wrenches of ALL candidates on one side is sought by cutting planes: a few
/// wrenches are kept, the hyperplane that separates them from the origin is tried on the whole
/// surface, and a wrench that contradicts it joins them. Either the kept ones close around the
/// origin, and there is no such hyperplane, or it is found.
pub fn prove_impossible(problem: &Problem, seed: u64) -> Option<Impossible> {
    let mut evaluator = Evaluator::new();
    let start = Stream::new(seed, Purpose::Proof, 0).subset(problem.len(), problem.contacts());
    let mut kept = problem.wrenches(&start);
    for _ in 0..ROUNDS {
        match evaluator.quality(&kept) {
            Ok(margin) if margin.is_force_closure() => return None,
            Ok(margin) => {
                let extremes = extremes(problem, &margin.direction);
                if extremes.high <= CLOSURE_TOLERANCE * extremes.scale {
                    return Some(Impossible::OneSided {
                        direction: margin.direction,
                    });
                }
                kept.push(extremes.highest);
            }
            Err(degenerate) => {
                let extremes = extremes(problem, &degenerate.direction);
                if extremes.high - extremes.low <= RANK_TOLERANCE * extremes.scale {
                    return Some(Impossible::Deficient {
                        rank: degenerate.rank,
                        direction: degenerate.direction,
                    });
                }
                kept.push(extremes.highest);
                kept.push(extremes.lowest);
            }
        }
    }
    None
}

/// The wrenches of all candidates that reach farthest along and against a direction.
struct Extremes {
    high: f64,
    highest: Wrench,
    low: f64,
    lowest: Wrench,
    /// Length of the longest wrench.
    scale: f64,
}

fn extremes(problem: &Problem, direction: &Wrench) -> Extremes {
    let mut found = Extremes {
        high: f64::NEG_INFINITY,
        highest: Wrench::zeros(),
        low: f64::INFINITY,
        lowest: Wrench::zeros(),
        scale: 0.0,
    };
    let mut wrenches = Vec::new();
    for candidate in 0..problem.len() as u32 {
        wrenches.clear();
        problem.push_wrenches(candidate, &mut wrenches);
        for w in &wrenches {
            let height = w.dot(direction);
            if height > found.high {
                (found.high, found.highest) = (height, *w);
            }
            if height < found.low {
                (found.low, found.lowest) = (height, *w);
            }
            found.scale = found.scale.max(w.norm());
        }
    }
    found
}
