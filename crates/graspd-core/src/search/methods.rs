//! The search methods by name.

use super::driver::{Driver, Outcome, Search};
use super::genetic::Genetic;
use super::local::Local;
use super::memetic::Memetic;
use super::population::Generations;
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
    ///
    /// ```
    /// use graspd_core::Interrupt;
    /// use graspd_core::contact::{Cone, ConeEdges, ContactModel, Friction};
    /// use graspd_core::mesh::{Mesh, solids};
    /// use graspd_core::search::{
    ///     Budget, Initial, InitialMode, Method, Search, SearchProblem, SearchSettings, initial_grasp,
    /// };
    /// use graspd_core::wrench::{EdgeNorm, TorqueScale, WrenchModel, WrenchSpace};
    ///
    /// let mesh = Mesh::prepare(solids::sphere(1.0, 12, 24)).unwrap();
    /// let center = mesh.report().center_of_mass;
    /// let model = WrenchModel {
    ///     contact_model: ContactModel::Hard {
    ///         friction: Friction::new(0.5).unwrap(),
    ///         cone: Cone::Pyramid(ConeEdges::new(8).unwrap()),
    ///     },
    ///     edge_norm: EdgeNorm::UnitEdge,
    ///     space: WrenchSpace::L1,
    ///     center,
    ///     torque_scale: TorqueScale::MaxRadius.value(&mesh, &center),
    /// };
    /// let problem = SearchProblem::new(mesh.candidates(), model, 4).unwrap();
    ///
    /// let mut budget = Budget::new(Some(10_000));
    /// let never = Interrupt::never();
    /// let mode = InitialMode::Weak;
    /// let Initial::Found { grasp, quality } =
    ///     initial_grasp(&problem, mode, 1, &mut budget, never, &mut |_| {})
    /// else {
    ///     panic!("four fingers with friction can hold a sphere");
    /// };
    ///
    /// let outcome = Search {
    ///     problem: &problem,
    ///     settings: &SearchSettings {
    ///         population: 4,
    ///         generations: 2,
    ///         crossover_probability: 0.7,
    ///         mutation_probability: 0.2,
    ///         elitism: 1,
    ///         target_quality: None,
    ///     },
    ///     seed: 1,
    ///     budget: &mut budget,
    ///     interrupt: never,
    ///     observe: &mut |_| {},
    /// }
    /// .run(Method::Memetic, Some((grasp, quality)));
    ///
    /// let (_, best) = outcome.best.unwrap();
    /// assert!(best >= quality);
    /// // No exchange of one finger makes it better.
    /// assert!(outcome.single_exchange_optimal);
    /// assert!(budget.spent() <= 10_000);
    /// ```
    pub fn run(self, method: Method, first: Option<(Grasp, f64)>) -> Outcome {
        let seed = self.seed;
        match method {
            Method::Memetic => Driver::run(self, Memetic::new(first)),
            Method::ModifiedGa => {
                let first = first.map(|(grasp, _)| grasp);
                Driver::run(self, Generations::new(Genetic { first }))
            }
            Method::Local => Driver::run(self, Local::new(first, seed)),
            Method::Random => Driver::run(self, Generations::new(RandomSearch)),
        }
    }
}
