//! Random search: the yardstick that every method has to beat.
//!
//! Each generation draws as many random grasps as the population has individuals and evaluates them; nothing is
//! learnt from one generation to the next. Generation g draws from a stream of its own, so the first g generations
//! are the same however many follow. It ends after the given number of generations, at a cost of one evaluation for
//! each grasp that keeps the spacing.

use super::driver::{Driver, SearchMethod, Step};
use super::population::{Population, random_grasps};
use super::problem::Grasp;
use super::progress::StopReason;
use crate::random::{Purpose, Stream};

#[derive(Debug, Default)]
pub(super) struct RandomSearch {
    generation: usize,
    population: Population,
}

impl SearchMethod for RandomSearch {
    fn step(&mut self, driver: &mut Driver<'_>) -> Result<Step, StopReason> {
        if self.generation > driver.settings.generations {
            return Ok(Step::Ended(StopReason::GenerationLimit));
        }
        let mut stream = Stream::new(driver.seed, Purpose::Sample, self.generation as u64);
        let grasps = random_grasps(driver, None, &mut stream)?;
        self.population.0.clear();
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
