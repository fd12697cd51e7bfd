//! Random search: the yardstick that every method has to beat.
//!
//! Each generation draws as many random grasps as the population has individuals and evaluates them; nothing is
//! learnt from one generation to the next. Generation g draws from a stream of its own, so the first g generations
//! are the same however many follow. It ends after the given number of generations, at a cost of one evaluation for
//! each grasp that keeps the spacing.

use super::driver::Driver;
use super::population::{Breeding, Population, random_grasps};
use super::problem::Grasp;
use super::progress::StopReason;
use crate::random::{Purpose, Stream};

pub(super) struct RandomSearch;

impl Breeding for RandomSearch {
    fn breed(
        &mut self,
        generation: usize,
        population: &mut Population,
        driver: &mut Driver<'_>,
    ) -> Result<Vec<Grasp>, StopReason> {
        let mut stream = Stream::new(driver.seed, Purpose::Sample, generation as u64);
        let grasps = random_grasps(driver, None, &mut stream)?;
        population.0.clear();
        Ok(grasps)
    }
}
