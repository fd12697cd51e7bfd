//! The search methods by name.

use super::driver::{Driver, Outcome, Search};
use super::genetic::Genetic;
use super::local::Local;
use super::memetic::Memetic;
use super::problem::Grasp;
use super::random_search::RandomSearch;

/// Which search improves the first grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub enum Method {
    /// A genetic algorithm over grasps that no exchange of one finger improves.
    Memetic,
    /// The paper's modified genetic algorithm.
    ModifiedGa,
    /// The local optimum search of Roa & Suárez (2009).
    Local,
    /// The best of random grasps, with no first grasp to start from.
    Random,
}

impl Search<'_> {
    /// Searches with one method, from an optional first force-closure grasp and its ε.
    ///
    /// Work runs in parallel on the current rayon pool. Every random number comes from a stream of its purpose and
    /// index, so the outcome does not depend on the number of threads.
    pub fn run(self, method: Method, first: Option<(Grasp, f64)>) -> Outcome {
        let seed = self.seed;
        match method {
            Method::Memetic => Driver::run(self, Memetic::new(first)),
            Method::ModifiedGa => Driver::run(self, Genetic::new(first.map(|(grasp, _)| grasp))),
            Method::Local => Driver::run(self, Local::new(first, seed)),
            Method::Random => Driver::run(self, RandomSearch::default()),
        }
    }
}
