//! The driver that all searches share.
//!
//! A [`SearchMethod`] says how one step goes. The driver owns the rest, which is the same for every method: the
//! budget of evaluations, the best grasp so far, the history, the reports of progress, the target and the reason
//! why the search ended.
//!
//! ```text
//! repeat
//!     take a step of the method                   ended, failed or interrupted? stop
//!     if it completed a generation: add an entry to the history
//!     report progress                             interrupted, or target reached? stop
//! if evaluations were made since the last entry:  add one for the unfinished generation
//! ```
//!
//! Three rules hold at every report. The best grasp never gets worse. The history has one entry for each report
//! that announces one, so an observer may date the entries; only the last, for an unfinished generation, has no
//! report. The number of evaluations is within the budget.
//!
//! The driver ends because every method ends: a method bounds its own generations, and each step spends part of the
//! budget or proves something. Reports are made between blocks of some milliseconds of work, from the thread that
//! started the search. Their number does not depend on the clock, so the same input gives the same sequence of
//! states.

use super::evaluator::rounded;
use super::problem::{Grasp, SearchProblem};
use super::progress::{BestGrasp, Budget, Observer, Phase, SearchProgress, StopReason};
use crate::interrupt::Interrupt;

/// Parameters of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    /// Individuals of a genetic or random search, climbers of a memetic one; at least 2.
    pub population: usize,
    /// Generations bred from the initial population.
    pub generations: usize,
    /// Probability that a pair of parents is crossed, 0 to 1.
    pub crossover_probability: f64,
    /// Probability that a child is mutated, 0 to 1.
    pub mutation_probability: f64,
    /// Best individuals of a genetic search carried over unchanged, less than the population.
    pub elitism: usize,
    /// Stop once this quality is reached.
    pub target_quality: Option<f64>,
}

/// A search for the best grasp of one problem, ready to [run](Self::run).
pub struct Search<'a> {
    pub problem: &'a SearchProblem,
    pub settings: &'a SearchSettings,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Evaluations that are left; those that the search makes are taken from it.
    pub budget: &'a mut Budget,
    /// Checked many times a second.
    pub interrupt: Interrupt<'a>,
    /// Called many times a second with the state of the search.
    pub observe: Observer<'a>,
}

/// State of the search after a generation; entry 0 is the initial population.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Generation {
    pub generation: usize,
    /// Best quality ε so far.
    pub best: Option<f64>,
    /// Mean ε of the individuals that are force closure.
    pub mean: Option<f64>,
    /// How many individuals are force closure.
    pub force_closures: usize,
    /// Quality evaluations so far.
    pub evaluations: u64,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The best force-closure grasp and its ε.
    pub best: Option<(Grasp, f64)>,
    pub history: Vec<Generation>,
    pub stop: StopReason,
    /// Whether it is proven that no exchange of one finger for any other candidate improves the best
    /// grasp by more than [`EXCHANGE_TOLERANCE`](super::EXCHANGE_TOLERANCE).
    pub single_exchange_optimal: bool,
    /// Other good force-closure grasps and their ε, the best first: optima of a memetic search, the last
    /// population of others. The best may be among them.
    pub others: Vec<(Grasp, f64)>,
}

/// What a step of a method led to.
pub(super) enum Step {
    /// The present generation goes on.
    Unfinished,
    /// A generation is complete.
    GenerationEnded,
    /// The method has nothing left to do.
    Ended(StopReason),
}

/// One way to search.
pub(super) trait SearchMethod {
    /// Takes one step. The first step prepares what the method needs.
    ///
    /// # Errors
    /// When the budget is used up, the search is interrupted or the target is reached within the step.
    fn step(&mut self, driver: &mut Driver<'_>) -> Result<Step, StopReason>;

    /// ε of those grasps of the present generation that are force closure.
    fn qualities(&self) -> impl Iterator<Item = f64>;

    /// Whether a generation that was stopped before its end gets an entry in the history.
    fn records_unfinished_generation(&self) -> bool;

    /// Whether it is proven that no exchange of one finger improves the best grasp.
    fn is_proven_optimal(&self) -> bool {
        false
    }

    /// Good grasps that the method holds at the end and their ε, the best first.
    fn into_others(self) -> Vec<(Grasp, f64)>;
}

/// The state of a search, as far as it does not depend on the method.
pub(super) struct Driver<'a> {
    pub problem: &'a SearchProblem,
    pub settings: &'a SearchSettings,
    pub seed: u64,
    pub interrupt: Interrupt<'a>,
    budget: &'a mut Budget,
    observe: Observer<'a>,
    best: Option<(Grasp, f64)>,
    history: Vec<Generation>,
}

impl<'a> Driver<'a> {
    /// Runs a method to its end.
    pub fn run(search: Search<'a>, mut method: impl SearchMethod) -> Outcome {
        let mut driver = Self {
            problem: search.problem,
            settings: search.settings,
            seed: search.seed,
            interrupt: search.interrupt,
            budget: search.budget,
            observe: search.observe,
            best: None,
            history: Vec::new(),
        };
        let stop = driver.repeat_steps(&mut method);
        let recorded = driver.history.last().map_or(0, |last| last.evaluations);
        if driver.budget.spent() > recorded && method.records_unfinished_generation() {
            driver.record_generation(&method);
        }
        Outcome {
            best: driver.best,
            history: driver.history,
            stop,
            single_exchange_optimal: method.is_proven_optimal(),
            others: method.into_others(),
        }
    }

    fn repeat_steps(&mut self, method: &mut impl SearchMethod) -> StopReason {
        loop {
            let ended = match method.step(self) {
                // The initial population counts as a generation as soon as there is one.
                Ok(Step::Unfinished) => self.history.is_empty(),
                Ok(Step::GenerationEnded) => true,
                Ok(Step::Ended(stop)) | Err(stop) => return stop,
            };
            if ended {
                self.record_generation(method);
            }
            if let Err(stop) = self.report(ended) {
                return stop;
            }
        }
    }

    /// The best grasp so far and its ε.
    pub fn best(&self) -> Option<&(Grasp, f64)> {
        self.best.as_ref()
    }

    /// Takes a grasp as the best when it is better than the best so far, and returns whether it is. Of grasps
    /// whose qualities are equal up to rounding the first stays, so that a moved or turned body gives the same
    /// grasp.
    pub fn offer(&mut self, grasp: &[u32], quality: f64) -> bool {
        let best = self.best.as_ref().map(|(_, best)| rounded(*best));
        let is_better = best.is_none_or(|best| rounded(quality) > best);
        if is_better {
            self.best = Some((grasp.to_vec(), quality));
        }
        is_better
    }

    /// The evaluations that may still be made.
    pub fn budget(&mut self) -> &mut Budget {
        self.budget
    }

    /// Reports progress within a step.
    ///
    /// # Errors
    /// When the search is interrupted or the target is reached.
    pub fn checkpoint(&mut self) -> Result<(), StopReason> {
        self.report(false)
    }

    fn report(&mut self, generation_ended: bool) -> Result<(), StopReason> {
        let (problem, best) = (self.problem, self.best.as_ref());
        let quality = best.map(|(_, quality)| *quality);
        (self.observe)(&SearchProgress {
            phase: Phase::Search,
            generation: self.history.len().saturating_sub(1),
            evaluations: self.budget.spent(),
            best: quality,
            grasp: best.map(|(grasp, _)| BestGrasp { problem, grasp }),
            generation_ended,
        });
        self.interrupt.check()?;
        match (quality, self.settings.target_quality) {
            (Some(best), Some(target)) if best >= target => Err(StopReason::TargetQuality),
            _ => Ok(()),
        }
    }

    fn record_generation(&mut self, method: &impl SearchMethod) {
        let (mut sum, mut force_closures) = (0.0, 0);
        for quality in method.qualities() {
            sum += quality;
            force_closures += 1;
        }
        self.history.push(Generation {
            generation: self.history.len(),
            best: self.best.as_ref().map(|(_, quality)| *quality),
            mean: (force_closures > 0).then(|| sum / force_closures as f64),
            force_closures,
            evaluations: self.budget.spent(),
        });
    }
}
