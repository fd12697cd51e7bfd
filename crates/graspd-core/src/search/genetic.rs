//! The paper's modified genetic algorithm (paper, §3.3 and §3.4).
//!
//! An individual is a grasp: a set of m of the n candidates, written as a bit string with m ones. Its fitness is −ε,
//! or a penalty above every −ε when it is not force closure, so the search minimises. Operators that keep the number
//! of ones are what is modified: a usual crossover would give children with too many or too few contacts, and most
//! of the work would go into repairing them.
//!
//! ```text
//! population ← first grasp of Algorithm 1 and random grasps, evaluated
//! for each generation
//!     elite ← the `elitism` best
//!     until there are enough children
//!         two parents ← winners of tournaments of two
//!         with the crossover probability: cross them by Genetic Fix between two random cuts
//!         with the mutation probability: exchange a one of a child with a zero
//!     population ← elite and children, evaluated
//! ```
//!
//! Invariants. Every individual has exactly m ones ([`genetic_fix`](super::variation::genetic_fix) and
//! [`mutate`](super::variation::mutate) keep the number). With an elite the best individual is never lost; the
//! driver keeps the best of all generations in any case. A child whose contacts are too close or too far apart is
//! replaced by its parent, so a population that keeps the spacing goes on to do so.
//!
//! Repeatability. A pair of children is bred from a stream of its generation and its place, and individuals are
//! compared by qualities rounded to 30 bits. So the outcome depends neither on the
//! number of threads nor on how the body is placed.
//!
//! It ends after the given number of generations. Each costs population − elitism evaluations, which are nearly all
//! of the time and run in parallel; breeding a pair costs O(m log m).

use rayon::prelude::*;

use super::driver::{Driver, SearchSettings};
use super::evaluator::rounded;
use super::population::{Breeding, Individual, MADE_AT_ONCE, Population, random_grasps};
use super::problem::{Grasp, SearchProblem};
use super::progress::StopReason;
use super::variation::{cross, spaced_mutant};
use crate::random::{Purpose, Stream};

/// Pairs bred on one thread at least, as a pair takes less than a microsecond.
const PAIRS_PER_THREAD: usize = 64;

pub(super) struct Genetic {
    /// A force-closure individual of the initial population.
    pub first: Option<Grasp>,
}

impl Breeding for Genetic {
    fn breed(
        &mut self,
        generation: usize,
        population: &mut Population,
        driver: &mut Driver<'_>,
    ) -> Result<Vec<Grasp>, StopReason> {
        if generation == 0 {
            let mut stream = Stream::new(driver.seed, Purpose::Population, 0);
            return random_grasps(driver, self.first.take(), &mut stream);
        }
        let individuals = &mut population.0;
        individuals.sort_by(|a, b| fitness(a).total_cmp(&fitness(b)));
        let children = children(generation, individuals, driver)?;
        individuals.truncate(driver.settings.elitism);
        Ok(children)
    }
}

/// Makes the children of a generation, in parallel, each pair from its own stream.
fn children(
    generation: usize,
    population: &[Individual],
    driver: &mut Driver<'_>,
) -> Result<Vec<Grasp>, StopReason> {
    let (problem, settings, seed) = (driver.problem, driver.settings, driver.seed);
    let count = settings.population - settings.elitism;
    let pairs = count.div_ceil(2);
    let mut children: Vec<Grasp> = Vec::with_capacity(2 * pairs);
    for from in (0..pairs).step_by(MADE_AT_ONCE) {
        driver.checkpoint()?;
        let numbers = (from..pairs.min(from + MADE_AT_ONCE)).into_par_iter();
        let numbers = numbers.with_min_len(PAIRS_PER_THREAD);
        children.par_extend(numbers.flat_map_iter(|pair| {
            // A pair's stream is the same whichever thread breeds it.
            let index = (generation as u64) << 32 | pair as u64;
            let mut stream = Stream::new(seed, Purpose::Offspring, index);
            mate(problem, settings, population, &mut stream)
        }));
    }
    children.truncate(count);
    Ok(children)
}

/// Two children of two parents chosen from `population`. A parent takes the place of a child that does
/// not keep the spacing, and a mutation that never keeps it is left out.
fn mate(
    problem: &SearchProblem,
    settings: &SearchSettings,
    population: &[Individual],
    stream: &mut Stream,
) -> [Grasp; 2] {
    let parents = [(); 2].map(|()| &tournament(population, stream).grasp);
    let [mut first, mut second] = parents.map(Grasp::clone);
    if stream.chance(settings.crossover_probability) {
        cross(&mut first, &mut second, problem.len(), stream);
    }
    let mut children = [first, second];
    for (child, parent) in children.iter_mut().zip(parents) {
        if !problem.keeps_spacing(child) {
            child.clone_from(parent);
        }
        if stream.chance(settings.mutation_probability)
            && let Some(mutant) = spaced_mutant(child, problem, stream)
        {
            *child = mutant;
        }
    }
    children
}

/// −ε, and a penalty above every −ε when there is no force closure (paper, §3.3.1).
fn fitness(individual: &Individual) -> f64 {
    individual.quality.map_or(1.0, |quality| -rounded(quality))
}

/// The fitter of two random individuals.
fn tournament<'p>(population: &'p [Individual], stream: &mut Stream) -> &'p Individual {
    let a = &population[stream.below(population.len())];
    let b = &population[stream.below(population.len())];
    if fitness(b) < fitness(a) { b } else { a }
}
