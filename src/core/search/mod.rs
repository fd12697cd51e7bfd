//! Search for good grasps among the candidates of a body.

mod crossover;
mod genetic;
mod impossible;
mod initial;
mod polish;
mod problem;
mod progress;
mod random;

#[cfg(test)]
mod tests;

pub use genetic::{Generation, GeneticSettings, Outcome, modified_ga};
pub use impossible::Impossible;
pub use initial::{Initial, InitialMode, initial_grasp, nearest_start};
pub use polish::{PolishSettings, Polished, polish};
pub use problem::{CLOSURE_FLOOR, Grasp, Problem, closure_floor};
pub use progress::{Observer, Phase, Progress, Stop};
