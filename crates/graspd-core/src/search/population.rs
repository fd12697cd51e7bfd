//! Searches that go generation by generation: a population of individuals, and how the next one follows.

use rayon::prelude::*;

use super::driver::{Driver, SearchMethod, Step};
use super::evaluator::{GraspEvaluator, rounded};
use super::problem::{Grasp, SearchProblem};
use super::progress::StopReason;
use super::random_grasp::random_grasp;
use crate::random::Stream;

/// Individuals made between two reports of progress, before they are evaluated: some 10 ms.
pub(super) const MADE_AT_ONCE: usize = 4096;

/// An individual with its ε. `None` when it is not force closure, and when its contacts do not keep their
/// distances.
#[derive(Debug, Clone)]
pub(super) struct Individual {
    pub grasp: Grasp,
    pub quality: Option<f64>,
}

/// All individuals of a generation.
#[derive(Debug, Default)]
pub(super) struct Population(pub Vec<Individual>);

/// How the grasps of a generation are made.
pub(super) trait Breeding {
    /// Makes the grasps that join the population in generation `generation`, counted from 0, and removes the
    /// individuals that leave it. `population` is as it was until all grasps are made.
    fn breed(
        &mut self,
        generation: usize,
        population: &mut Population,
        driver: &mut Driver<'_>,
    ) -> Result<Vec<Grasp>, StopReason>;
}

/// A search of as many generations as the settings say.
pub(super) struct Generations<B> {
    breeding: B,
    /// The next generation to make.
    generation: usize,
    population: Population,
}

impl<B: Breeding> Generations<B> {
    pub fn new(breeding: B) -> Self {
        Self {
            breeding,
            generation: 0,
            population: Population::default(),
        }
    }
}

impl<B: Breeding> SearchMethod for Generations<B> {
    fn step(&mut self, driver: &mut Driver<'_>) -> Result<Step, StopReason> {
        if self.generation > driver.settings.generations {
            return Ok(Step::Ended(StopReason::GenerationLimit));
        }
        let population = &mut self.population;
        let grasps = self.breeding.breed(self.generation, population, driver)?;
        self.population.evaluate(&grasps, driver)?;
        self.generation += 1;
        Ok(Step::GenerationEnded)
    }

    fn qualities(&self) -> impl Iterator<Item = f64> {
        self.population.qualities()
    }

    fn records_unfinished_generation(&self) -> bool {
        !self.population.0.is_empty()
    }

    fn into_others(self) -> Vec<(Grasp, f64)> {
        self.population.into_grasps()
    }
}

/// Individuals evaluated between two reports of progress: with usual hulls some milliseconds, with
/// two of the largest allowed below a tenth of a second.
fn chunk_size(problem: &SearchProblem) -> usize {
    (4096 / problem.evaluation_cost()).clamp(2, 256)
}

/// Grasps for a whole population: `first` and random ones, as far as possible such that
/// [keep the spacing](SearchProblem::keeps_spacing).
pub(super) fn random_grasps(
    driver: &mut Driver<'_>,
    first: Option<Grasp>,
    stream: &mut Stream,
) -> Result<Vec<Grasp>, StopReason> {
    let problem = driver.problem;
    let mut grasps: Vec<Grasp> = first.into_iter().collect();
    while grasps.len() < driver.settings.population {
        if grasps.len().is_multiple_of(MADE_AT_ONCE) {
            driver.checkpoint()?;
        }
        let drawn = random_grasp(problem, stream, driver.interrupt)?;
        // One that does not keep the spacing is not evaluated, but the population keeps its size.
        grasps.push(drawn.unwrap_or_else(|| stream.subset(problem.len(), problem.contacts())));
    }
    Ok(grasps)
}

impl Population {
    /// Evaluates grasps in parallel and adds them, as far as the budget goes. Grasps that do not keep the spacing
    /// are added without an evaluation.
    fn evaluate(&mut self, grasps: &[Grasp], driver: &mut Driver<'_>) -> Result<(), StopReason> {
        let problem = driver.problem;
        for chunk in grasps.chunks(chunk_size(problem)) {
            let left = usize::try_from(driver.budget().left()).unwrap_or(usize::MAX);
            let kept: Vec<bool> = chunk.iter().map(|g| problem.keeps_spacing(g)).collect();
            // Only what keeps the spacing counts against the budget: the chunk ends before the first that is one
            // too many.
            let mut counted = (0..chunk.len()).filter(|&i| kept[i]);
            let allowed = &chunk[..counted.nth(left).unwrap_or(chunk.len())];
            let qualities: Vec<Option<f64>> = allowed
                .par_iter()
                .map_init(
                    || GraspEvaluator::new(problem),
                    |evaluator, grasp| evaluator.epsilon(grasp),
                )
                .collect();
            let evaluated = kept[..allowed.len()].iter().filter(|kept| **kept).count();
            driver.budget().spend(evaluated as u64);
            for (grasp, quality) in allowed.iter().zip(qualities) {
                if let Some(quality) = quality {
                    driver.offer(grasp, quality);
                }
                self.0.push(Individual {
                    grasp: grasp.clone(),
                    quality,
                });
            }
            if allowed.len() < chunk.len() {
                return Err(StopReason::EvaluationLimit);
            }
            driver.checkpoint()?;
        }
        Ok(())
    }

    /// ε of those that are force closure.
    fn qualities(&self) -> impl Iterator<Item = f64> {
        self.0.iter().filter_map(|individual| individual.quality)
    }

    /// Those that are force closure and their ε, the best first.
    fn into_grasps(self) -> Vec<(Grasp, f64)> {
        let closed = |one: Individual| Some((one.grasp, one.quality?));
        let mut grasps: Vec<(Grasp, f64)> = self.0.into_iter().filter_map(closed).collect();
        grasps.sort_by(|(_, a), (_, b)| rounded(*b).total_cmp(&rounded(*a)));
        grasps
    }
}
