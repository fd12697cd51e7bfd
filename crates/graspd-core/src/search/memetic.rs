//! Memetic search: a genetic algorithm over grasps that no exchange of one finger improves.
//!
//! A plain genetic algorithm spends its evaluations on grasps that a small step would improve. Here every individual
//! is a climber: it exchanges one finger after the other by [`Exchange`], which bounds all candidates on the body at
//! once and evaluates only the few whose bound is good, until it is proven that no candidate anywhere is better in
//! any one place. The optima so found are the population that is crossed and mutated.
//!
//! ```text
//! climbers ← first grasp of Algorithm 1 and random grasps, `population` of them
//! repeat
//!     advance each climber by some visits and evaluations, side by side
//!     for each climber, in order
//!         note whether it has the best grasp
//!         if it reached a local optimum: keep the optimum among the elite
//!         if it did, or is stuck without force closure: replace it by
//!             a random grasp, one time in ten, or else
//!             a child of two of the elite: tournaments of two, Genetic Fix (Ngo & Li 1998), mutation
//! until population · generations climbers have stopped, and the best grasp is at a local optimum
//! ```
//!
//! A climber that stops climbing is replaced at once, so all threads have work. A generation is over whenever as many
//! have stopped as climb side by side. When the loop ends by itself, no exchange of one finger improves the best
//! grasp, which is reported as proven unless a hull could not be finished on the way.
//!
//! Repeatability. The work of a climber in one step does not depend on the clock, uses its own memory only, and is
//! reviewed in its place. The k-th climber comes from the k-th stream. So the outcome does not depend on the number of
//! threads.
//!
//! It ends. A visit improves the climber by a share of at least
//! [`EXCHANGE_TOLERANCE`](super::EXCHANGE_TOLERANCE), proves its slot, or rules out candidates that are not evaluated
//! again before the next improvement. There are finitely many of each, so every climber stops; one that is not force
//! closure is replaced after a round without success. A visit costs one pass over the candidates at some billion
//! bounds a second, and at most [`VISIT`] evaluations.

use rayon::prelude::*;

use super::candidate_scan::CandidateScan;
use super::driver::{Driver, SearchMethod, Step};
use super::evaluator::rounded;
use super::exchange::{Climber, Exchange};
use super::problem::{Grasp, SearchProblem};
use super::progress::StopReason;
use super::random_grasp::random_grasp;
use super::variation::{cross, spaced_mutant};
use crate::random::{Purpose, Stream};

/// Evaluations of one visit to a slot. More find a better candidate for it, and waste them on a grasp that
/// changes in the next slot; of 2, 3, 4, 6, 8, 12 and 40 this gave the best grasps in a second.
const VISIT: u64 = 4;

/// Share of climbers that start from a random grasp.
const RESTART: f64 = 0.1;

/// Optima kept for each climber.
const ELITE_PER_CLIMBER: usize = 2;

/// Wrenches evaluated by one climber between two reports of progress: some milliseconds.
const WRENCHES: usize = 4096;

/// Candidates bounded by one climber between two reports of progress: some milliseconds.
const BOUNDED: usize = 1 << 20;

/// Climbers made between two reports of progress.
const STARTS: usize = 1024;

/// Climbers advanced between two reports of progress, fewer where each has much to do.
const SIDE_BY_SIDE: usize = 32;

/// Candidates that are bounded in the time of evaluating a wrench.
const BOUNDED_PER_WRENCH: usize = 64;

/// The memetic search between two steps.
#[derive(Debug)]
pub(super) struct Memetic {
    /// A force-closure grasp to start with.
    first: Option<(Grasp, f64)>,
    /// The candidates, laid out in the first step.
    scan: Option<CandidateScan>,
    climbers: Vec<Climber>,
    /// Grasps that climbers stopped at and their ε, the best first.
    elite: Vec<(Grasp, f64)>,
    /// What is known of the best grasp.
    best: Standing,
    /// Climbers made so far.
    started: u64,
    /// Climbers that stopped so far.
    stopped: u64,
}

/// What is known of a grasp that climbed.
#[derive(Debug, Clone, Copy, Default)]
struct Standing {
    /// Whether its climber has stopped at it.
    is_local_optimum: bool,
    /// Whether it is proven that no exchange of one finger improves it.
    is_proven: bool,
}

/// The work of one climber in one step.
#[derive(Debug, Clone, Copy)]
struct Allowance {
    visits: usize,
    evaluations: u64,
}

impl Memetic {
    pub fn new(first: Option<(Grasp, f64)>) -> Self {
        Self {
            first,
            scan: None,
            climbers: Vec::new(),
            elite: Vec::new(),
            best: Standing::default(),
            started: 0,
            stopped: 0,
        }
    }

    /// Lays out the candidates and makes all climbers. Returns `false` when no grasp was found that keeps the
    /// spacing.
    fn prepare(&mut self, driver: &mut Driver<'_>) -> Result<bool, StopReason> {
        if let Some((grasp, quality)) = self.first.take() {
            driver.offer(&grasp, quality);
            self.climbers.push(Climber::new(grasp, quality));
        }
        self.scan = Some(CandidateScan::new(driver.problem, driver.interrupt)?);
        while self.climbers.len() < driver.settings.population {
            if self.climbers.len().is_multiple_of(STARTS) {
                driver.checkpoint()?;
            }
            match self.start(driver)? {
                Some(climber) => self.climbers.push(climber),
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    /// Whether there is work left.
    fn goes_on(&self, driver: &Driver<'_>) -> bool {
        let settings = driver.settings;
        let enough = settings.population as u64 * settings.generations as u64;
        self.stopped < enough || driver.best().is_some() && !self.best.is_local_optimum
    }

    /// Advances all climbers, a few at a time so that a large population can be stopped.
    fn advance(
        &mut self,
        driver: &mut Driver<'_>,
        allowances: &[Allowance],
    ) -> Result<(), StopReason> {
        let Some(scan) = &self.scan else {
            return Ok(());
        };
        let problem = driver.problem;
        let some = side_by_side(problem);
        for (climbers, allowances) in self.climbers.chunks_mut(some).zip(allowances.chunks(some)) {
            let pairs = climbers.par_iter_mut().zip(allowances);
            pairs.for_each_init(
                || Exchange::new(problem, scan),
                |exchange, (climber, allowance)| climb(exchange, climber, *allowance),
            );
            driver.checkpoint()?;
        }
        Ok(())
    }

    /// The work of each climber in the next step. What is left of the budget is shared out evenly, the first
    /// climbers get the rest of the division.
    fn allowances(&self, driver: &mut Driver<'_>) -> Result<Vec<Allowance>, StopReason> {
        let problem = driver.problem;
        let most = (WRENCHES / problem.evaluation_cost()).max(1) as u64;
        let count = self.climbers.len() as u64;
        let left = driver.budget().left_or_stop()?;
        let visits = (BOUNDED / problem.len()).clamp(1, problem.contacts());
        let allowances = (0..count).map(|i| Allowance {
            visits,
            evaluations: most.min(left / count + u64::from(i < left % count)),
        });
        Ok(allowances.collect())
    }

    /// Counts the evaluations of all climbers, takes their grasps, and replaces those that have stopped unless the
    /// search is `interrupted`. Returns whether a generation is over.
    fn review(&mut self, driver: &mut Driver<'_>, interrupted: bool) -> Result<bool, StopReason> {
        let population = driver.settings.population as u64;
        let generation = self.stopped / population;
        for i in 0..self.climbers.len() {
            let climber = &mut self.climbers[i];
            driver.budget().spend(climber.take_evaluations());
            let standing = Standing {
                is_local_optimum: climber.is_local_optimum(),
                is_proven: climber.is_proven_optimal(),
            };
            // A climber that never became force closure has no quality, and no proof that ends it.
            let is_stuck = climber.quality.is_none() && climber.idle() >= driver.problem.contacts();
            if let Some(quality) = climber.quality {
                let mut grasp = climber.grasp.clone();
                grasp.sort_unstable();
                self.offer(driver, &grasp, quality, standing);
                if standing.is_local_optimum {
                    self.keep(grasp, quality, driver.settings.population);
                }
            }
            if standing.is_local_optimum || is_stuck {
                self.stopped += 1;
                if !interrupted && let Some(climber) = self.start(driver)? {
                    self.climbers[i] = climber;
                }
            }
        }
        Ok(self.stopped / population > generation)
    }

    /// Offers a grasp to the driver and keeps what is known of the best. Two climbers may come to the same grasp:
    /// what either has found out holds.
    fn offer(&mut self, driver: &mut Driver<'_>, grasp: &Grasp, quality: f64, standing: Standing) {
        if driver.best().is_some_and(|(best, _)| best == grasp) {
            self.best.is_local_optimum |= standing.is_local_optimum;
            self.best.is_proven |= standing.is_proven;
        } else if driver.offer(grasp, quality) {
            self.best = standing;
        }
    }

    /// Adds an optimum to the best that are known.
    fn keep(&mut self, grasp: Grasp, quality: f64, population: usize) {
        if self.elite.iter().any(|(known, _)| *known == grasp) {
            return;
        }
        let place = self
            .elite
            .partition_point(|(_, known)| rounded(*known) >= rounded(quality));
        self.elite.insert(place, (grasp, quality));
        self.elite.truncate(ELITE_PER_CLIMBER * population);
    }

    /// A new climber, from a stream of its own: a child of two optima or a random grasp. `None` when no
    /// grasp was found that keeps the spacing.
    fn start(&mut self, driver: &Driver<'_>) -> Result<Option<Climber>, StopReason> {
        let (problem, settings) = (driver.problem, driver.settings);
        let mut stream = Stream::new(driver.seed, Purpose::Climb, self.started);
        self.started += 1;
        let best = driver.best().map(|(grasp, _)| grasp);
        let has_parents = !self.elite.is_empty() || best.is_some();
        if !has_parents || stream.chance(RESTART) {
            if let Some(grasp) = random_grasp(problem, &mut stream, driver.interrupt)? {
                return Ok(Some(Climber::unknown(grasp)));
            }
            if !has_parents {
                return Ok(None);
            }
        }
        let parent = self.parent(best, &mut stream);
        let (mut child, mut other) = (parent.clone(), self.parent(best, &mut stream));
        if stream.chance(settings.crossover_probability) {
            cross(&mut child, &mut other, problem.len(), &mut stream);
        }
        if !problem.keeps_spacing(&child) {
            child.clone_from(&parent);
        }
        // A child like its parent would only climb to where the parent is.
        let first = child == parent || stream.chance(settings.mutation_probability);
        let second = stream.chance(settings.mutation_probability);
        for _ in 0..usize::from(first) + usize::from(second) {
            child = spaced_mutant(&child, problem, &mut stream).unwrap_or(child);
        }
        Ok(Some(Climber::unknown(child)))
    }

    /// The winner of a tournament of two among the optima, or the best grasp before there are any.
    fn parent(&self, best: Option<&Grasp>, stream: &mut Stream) -> Grasp {
        match (best, self.elite.len()) {
            (Some(best), 0) => best.clone(),
            (_, count) => {
                // The elite is sorted: the lower place is the better grasp.
                let (a, b) = (stream.below(count), stream.below(count));
                self.elite[a.min(b)].0.clone()
            }
        }
    }
}

impl SearchMethod for Memetic {
    fn step(&mut self, driver: &mut Driver<'_>) -> Result<Step, StopReason> {
        if self.scan.is_none() && !self.prepare(driver)? || !self.goes_on(driver) {
            return Ok(Step::Ended(StopReason::GenerationLimit));
        }
        let allowances = self.allowances(driver)?;
        let advanced = self.advance(driver, &allowances);
        // What was found before an interruption counts.
        let is_over = self.review(driver, advanced.is_err())?;
        advanced?;
        Ok(match is_over {
            true => Step::GenerationEnded,
            false => Step::Unfinished,
        })
    }

    fn qualities(&self) -> impl Iterator<Item = f64> {
        self.climbers.iter().filter_map(|climber| climber.quality)
    }

    fn records_unfinished_generation(&self) -> bool {
        true
    }

    fn is_proven_optimal(&self) -> bool {
        self.best.is_proven
    }

    fn into_others(self) -> Vec<(Grasp, f64)> {
        self.elite
    }
}

/// Climbers to advance between two reports of progress: enough for all threads, whose work is even only
/// over some climbers each.
fn side_by_side(problem: &SearchProblem) -> usize {
    let work = problem.evaluation_cost() + problem.len() / BOUNDED_PER_WRENCH;
    let least = 2 * rayon::current_num_threads();
    (2 * WRENCHES / work).clamp(least, least.max(SIDE_BY_SIDE))
}

/// Visits slots until the allowance is used up or the climber has stopped.
fn climb(exchange: &mut Exchange<'_>, climber: &mut Climber, allowance: Allowance) {
    let mut left = allowance.evaluations;
    for _ in 0..allowance.visits {
        if left == 0 || climber.is_local_optimum() {
            break;
        }
        left -= exchange.visit(climber, VISIT.min(left));
    }
}
