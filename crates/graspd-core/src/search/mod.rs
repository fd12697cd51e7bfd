//! Search for good grasps among the candidates of a body.
//!
//! A [`SearchProblem`] holds the candidates and what every grasp has in common. [`initial_grasp`] finds a first
//! force-closure grasp (Algorithm 1) or proves that none exists; a [`Search`] improves it by one of four
//! [methods](Method), run by a common driver; [`exhaustive_search`] settles small problems; [`polish()`] lets the
//! contacts of the best grasp slide over the surface.

mod candidate_scan;
mod driver;
mod evaluator;
mod exchange;
mod exhaustive;
mod genetic;
mod impossible;
mod initial;
mod local;
mod memetic;
mod methods;
mod polish;
mod population;
mod problem;
mod progress;
mod random_grasp;
mod random_search;
mod variation;

#[cfg(test)]
mod method_tests;
#[cfg(test)]
mod tests;

pub use driver::{Generation, Outcome, Search, SearchSettings};
pub use exchange::EXCHANGE_TOLERANCE;
pub use exhaustive::{AllGrasps, exhaustive_search};
pub use impossible::{Impossible, prove_impossible};
pub use initial::{Initial, InitialMode, initial_grasp, nearest_start};
pub use methods::Method;
pub use polish::{PolishSettings, Polished, polish};
pub use problem::{CLOSURE_FLOOR, Grasp, SearchProblem, closure_floor};
pub use progress::{BestGrasp, Budget, Observer, Phase, SearchProgress, StopReason};
