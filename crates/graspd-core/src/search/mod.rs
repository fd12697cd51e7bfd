//! Search for good grasps among the candidates of a body.

mod crossover;
mod exchange;
mod exhaustive;
mod fitting;
mod genetic;
mod impossible;
mod initial;
mod local;
mod memetic;
mod polish;
mod problem;
mod progress;
mod sites;

#[cfg(test)]
mod method_tests;
#[cfg(test)]
mod tests;

pub use exchange::EXCHANGE_TOLERANCE;
pub use exhaustive::{Exhaustion, exhaust};
pub use genetic::{Generation, GeneticSettings, Outcome, modified_ga, random_search};
pub use impossible::{Impossible, impossible};
pub use initial::{Initial, InitialMode, initial_grasp, nearest_start};
pub use local::local;
pub use memetic::memetic;
pub use polish::{PolishSettings, Polished, polish};
pub use problem::{CLOSURE_FLOOR, Grasp, Problem, closure_floor};
pub use progress::{BestGrasp, Observer, Phase, Progress, Stop};
