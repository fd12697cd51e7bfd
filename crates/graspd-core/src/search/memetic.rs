//! Memetic search: a genetic algorithm over grasps that no exchange of one finger improves.
//!
//! Every individual climbs by exchanges with cuts ([`Exchange`]) until it is proven that no candidate
//! anywhere on the body is better in any one place. The optima are kept, crossed by Genetic Fix (Ngo & Li
//! 1998), mutated, and their children climb in turn; now and then one starts from a random grasp. A climber
//! that arrives is replaced at once, so all threads have work; a generation is over whenever as many have
//! arrived as climb side by side.

use rayon::prelude::*;

use super::crossover::{genetic_fix, mutate};
use super::exchange::{Climber, Exchange};
use super::fitting::random_grasp;
use super::genetic::{Generation, GeneticSettings, Outcome};
use super::problem::{Grasp, Problem, rounded};
use super::progress::{BestGrasp, Observer, Phase, Progress, Stop};
use super::sites::Sites;
use crate::interrupt::Interrupt;
use crate::random::{Purpose, Stream};

/// Evaluations of one visit to a slot. More find a better candidate for it, and waste them on a grasp that
/// changes in the next slot; of 2, 3, 4, 6, 8, 12 and 40 this gave the best grasps in a second.
const VISIT: u64 = 4;

/// Share of climbers that start from a random grasp.
const RESTART: f64 = 0.1;

/// Mutants tried for one that keeps its distances.
const MUTATIONS: usize = 8;

/// Optima kept for each climber.
const ELITES: usize = 2;

/// Wrenches evaluated by one climber between two calls of the observer: some milliseconds.
const WRENCHES: usize = 4096;

/// Candidates looked at by one climber between two calls of the observer: some milliseconds.
const SITES: usize = 1 << 20;

/// Climbers made between two calls of the observer.
const STARTS: usize = 1024;

/// Climbers advanced between two calls of the observer, fewer where each has much to do.
const SIDE_BY_SIDE: usize = 32;

/// Candidates that are looked at in the time of evaluating a wrench.
const SITES_A_WRENCH: usize = 64;

/// The best grasp of all so far.
#[derive(Debug, Clone)]
struct Best {
    grasp: Grasp,
    quality: f64,
    /// Whether its climber has come to rest.
    arrived: bool,
    /// Whether it is proven that no exchange of one finger improves it.
    proven: bool,
}

/// Runs `settings.population` climbers at once until `settings.generations` times as many have arrived and
/// the best of all is proven to be optimal in each finger, or a limit is reached.
///
/// `first` is a force-closure grasp to start with, and its ε. Climbers are advanced in parallel on the
/// current rayon pool, each by an amount of work that does not depend on the clock, and looked at in their
/// order; so the outcome does not depend on the number of threads. `evaluations` is counted on. The history
/// has the best grasp so far and the mean of those that climb.
pub fn memetic(
    problem: &Problem,
    settings: &GeneticSettings,
    seed: u64,
    first: Option<(Grasp, f64)>,
    evaluations: &mut u64,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) -> Outcome {
    let mut run = Run {
        problem,
        settings,
        seed,
        evaluations,
        interrupt,
        observe,
        climbers: Vec::new(),
        elites: Vec::new(),
        best: None,
        history: Vec::new(),
        started: 0,
        arrived: 0,
    };
    let stop = match run.search(first) {
        Err(stop) => stop,
        Ok(()) => Stop::GenerationLimit,
    };
    run.close_history();
    let single_exchange_optimal = run.best.as_ref().is_some_and(|best| best.proven);
    Outcome {
        best: run.best.map(|best| (best.grasp, best.quality)),
        history: run.history,
        stop,
        single_exchange_optimal,
        others: run.elites,
    }
}

struct Run<'a, 'o> {
    problem: &'a Problem,
    settings: &'a GeneticSettings,
    seed: u64,
    evaluations: &'a mut u64,
    interrupt: Interrupt<'o>,
    observe: Observer<'o>,
    climbers: Vec<Climber>,
    /// Grasps that climbers arrived at and their ε, the best first.
    elites: Vec<(Grasp, f64)>,
    best: Option<Best>,
    history: Vec<Generation>,
    started: u64,
    arrived: u64,
}

/// What one climber may do between two looks at all of them.
#[derive(Clone, Copy)]
struct Allowance {
    visits: usize,
    evaluations: u64,
}

impl Run<'_, '_> {
    fn search(&mut self, first: Option<(Grasp, f64)>) -> Result<(), Stop> {
        let population = self.settings.population;
        if let Some((grasp, quality)) = first {
            self.offer(&grasp, quality, false, false);
            self.climbers.push(Climber::new(grasp, quality));
        }
        let sites = &Sites::new(self.problem, self.interrupt)?;
        while self.climbers.len() < population {
            if self.climbers.len().is_multiple_of(STARTS) {
                let progress = self.progress(false);
                (self.observe)(&progress);
                self.interrupt.check()?;
            }
            match self.start()? {
                Some(climber) => self.climbers.push(climber),
                None => return Ok(()),
            }
        }
        let wanted = population as u64 * self.settings.generations as u64;
        while self.arrived < wanted || self.best.as_ref().is_some_and(|best| !best.arrived) {
            let allowances = self.allowances()?;
            let stopped = self.advance(sites, &allowances);
            let over = self.look(stopped.is_err())?;
            stopped?;
            self.report(over)?;
        }
        Ok(())
    }

    /// Advances all climbers, a few at a time so that a large population can be stopped.
    fn advance(&mut self, sites: &Sites, allowances: &[Allowance]) -> Result<(), Stop> {
        let problem = self.problem;
        let mut rest = std::mem::take(&mut self.climbers);
        let mut stopped = Ok(());
        let some = side_by_side(problem);
        for (climbers, allowances) in rest.chunks_mut(some).zip(allowances.chunks(some)) {
            let pairs = climbers.par_iter_mut().zip(allowances);
            pairs.for_each_init(
                || Exchange::new(problem, sites),
                |exchange, (climber, allowance)| climb(exchange, climber, *allowance),
            );
            let progress = self.progress(false);
            (self.observe)(&progress);
            stopped = self.interrupt.check().map_err(Stop::from);
            if stopped.is_err() {
                break;
            }
        }
        self.climbers = rest;
        stopped
    }

    /// What the climbers may do next, one after the other. The limit of evaluations is shared out evenly.
    fn allowances(&self) -> Result<Vec<Allowance>, Stop> {
        let problem = self.problem;
        let most = (WRENCHES / problem.effort()).max(1) as u64;
        let count = self.climbers.len() as u64;
        let left = match self.settings.evaluation_limit {
            Some(limit) => limit.saturating_sub(*self.evaluations),
            None => u64::MAX,
        };
        if left == 0 {
            return Err(Stop::EvaluationLimit);
        }
        let visits = (SITES / problem.len()).clamp(1, problem.contacts());
        let allowances = (0..count).map(|i| Allowance {
            visits,
            evaluations: most.min(left / count + u64::from(i < left % count)),
        });
        Ok(allowances.collect())
    }

    /// Takes note of what all climbers have, and replaces those that have arrived. Says whether a
    /// generation is over.
    fn look(&mut self, stopped: bool) -> Result<bool, Stop> {
        let population = self.settings.population as u64;
        let generation = self.arrived / population;
        for i in 0..self.climbers.len() {
            let climber = &mut self.climbers[i];
            *self.evaluations += std::mem::take(&mut climber.evaluations);
            let (quality, proven) = (climber.quality, climber.is_optimal());
            let arrived = climber.has_arrived();
            let lost = quality.is_none() && climber.idle() >= self.problem.contacts();
            let mut grasp = climber.grasp.clone();
            grasp.sort_unstable();
            if let Some(quality) = quality {
                self.offer(&grasp, quality, arrived, proven);
                if arrived {
                    self.keep(grasp, quality);
                }
            }
            if arrived || lost {
                self.arrived += 1;
                if !stopped && let Some(climber) = self.start()? {
                    self.climbers[i] = climber;
                }
            }
        }
        Ok(self.arrived / population > generation)
    }

    fn offer(&mut self, grasp: &Grasp, quality: f64, arrived: bool, proven: bool) {
        match &mut self.best {
            Some(best) if best.grasp == *grasp => {
                best.arrived |= arrived;
                best.proven |= proven;
            }
            Some(best) if rounded(best.quality) >= rounded(quality) => {}
            best => {
                *best = Some(Best {
                    grasp: grasp.clone(),
                    quality,
                    arrived,
                    proven,
                });
            }
        }
    }

    /// Adds an optimum to the best that are known.
    fn keep(&mut self, grasp: Grasp, quality: f64) {
        if self.elites.iter().any(|(elite, _)| *elite == grasp) {
            return;
        }
        let place = self
            .elites
            .partition_point(|(_, elite)| rounded(*elite) >= rounded(quality));
        self.elites.insert(place, (grasp, quality));
        self.elites.truncate(ELITES * self.settings.population);
    }

    /// A new climber, from a stream of its own: a child of two optima or a random grasp. `None` when no
    /// grasp was found that keeps its distances.
    fn start(&mut self) -> Result<Option<Climber>, Stop> {
        let problem = self.problem;
        let (n, settings) = (problem.len(), self.settings);
        let mut stream = Stream::new(self.seed, Purpose::Climb, self.started);
        self.started += 1;
        let is_first = self.elites.is_empty() && self.best.is_none();
        if is_first || stream.chance(RESTART) {
            if let Some(grasp) = random_grasp(problem, &mut stream, self.interrupt)? {
                return Ok(Some(Climber::unknown(grasp)));
            }
            if is_first {
                return Ok(None);
            }
        }
        let parent = self.parent(&mut stream);
        let (mut child, mut other) = (parent.clone(), self.parent(&mut stream));
        if stream.chance(settings.crossover_probability) {
            let cuts = stream.subset(n + 1, 2);
            genetic_fix(&mut child, &mut other, cuts[0], cuts[1]);
        }
        if !problem.fits(&child) {
            child.clone_from(&parent);
        }
        let again = child == parent || stream.chance(settings.mutation_probability);
        let twice = stream.chance(settings.mutation_probability);
        for _ in 0..usize::from(again) + usize::from(twice) {
            let mutant = (0..MUTATIONS).find_map(|_| {
                let mut mutant = child.clone();
                mutate(&mut mutant, n, &mut stream);
                problem.fits(&mutant).then_some(mutant)
            });
            child = mutant.unwrap_or(child);
        }
        Ok(Some(Climber::unknown(child)))
    }

    /// The winner of a tournament of two among the optima, or before there are any the best grasp.
    fn parent(&self, stream: &mut Stream) -> Grasp {
        match (&self.best, self.elites.len()) {
            (Some(best), 0) => best.grasp.clone(),
            (_, count) => {
                let (a, b) = (stream.below(count), stream.below(count));
                self.elites[a.min(b)].0.clone()
            }
        }
    }

    fn progress(&self, generation_ended: bool) -> Progress<'static> {
        Progress {
            phase: Phase::Search,
            generation: self.history.len().saturating_sub(1),
            evaluations: *self.evaluations,
            best: self.best.as_ref().map(|best| best.quality),
            grasp: None,
            generation_ended,
        }
    }

    fn report(&mut self, generation_ended: bool) -> Result<(), Stop> {
        let generation_ended = generation_ended || self.history.is_empty();
        if generation_ended {
            self.note_generation();
        }
        let problem = self.problem;
        let grasp = self.best.as_ref().map(|best| BestGrasp {
            problem,
            grasp: &best.grasp,
        });
        let progress = Progress {
            grasp,
            ..self.progress(generation_ended)
        };
        (self.observe)(&progress);
        self.interrupt.check()?;
        let best = self.best.as_ref().map(|best| best.quality);
        match (best, self.settings.target_quality) {
            (Some(best), Some(target)) if best >= target => Err(Stop::TargetQuality),
            _ => Ok(()),
        }
    }

    /// Enters the generation that the search was stopped in.
    fn close_history(&mut self) {
        let known = self.history.last().map_or(0, |last| last.evaluations);
        if *self.evaluations > known {
            self.note_generation();
        }
    }

    fn note_generation(&mut self) {
        let climbers = self.climbers.iter();
        let closed: Vec<f64> = climbers.filter_map(|climber| climber.quality).collect();
        self.history.push(Generation {
            generation: self.history.len(),
            best: self.best.as_ref().map(|best| best.quality),
            mean: (!closed.is_empty()).then(|| closed.iter().sum::<f64>() / closed.len() as f64),
            force_closures: closed.len(),
            evaluations: *self.evaluations,
        });
    }
}

/// Climbers to advance between two calls of the observer: enough for all threads, whose work is even only
/// over some climbers each.
fn side_by_side(problem: &Problem) -> usize {
    let work = problem.effort() + problem.len() / SITES_A_WRENCH;
    let least = 2 * rayon::current_num_threads();
    (2 * WRENCHES / work).clamp(least, least.max(SIDE_BY_SIDE))
}

/// Visits slots until the allowance is used up or the climber has arrived.
fn climb(exchange: &mut Exchange<'_>, climber: &mut Climber, allowance: Allowance) {
    let used = climber.evaluations;
    for _ in 0..allowance.visits {
        let left = allowance.evaluations - (climber.evaluations - used);
        if left == 0 || climber.has_arrived() {
            break;
        }
        exchange.visit(climber, VISIT.min(left));
    }
}
