//! The paper's modified genetic algorithm (paper, §3.3 and §3.4).

use rayon::prelude::*;

use super::crossover::{genetic_fix, mutate};
use super::fitting::random_grasp;
use super::problem::{Grasp, GraspEvaluator, Problem, rounded};
use super::progress::{BestGrasp, Observer, Phase, Progress, Stop};
use crate::interrupt::Interrupt;
use crate::random::{Purpose, Stream};

/// Parameters of the modified genetic algorithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneticSettings {
    /// Individuals, at least 2.
    pub population: usize,
    /// Generations bred from the initial population.
    pub generations: usize,
    /// Probability that a pair of parents is crossed, 0 to 1.
    pub crossover_probability: f64,
    /// Probability that a child is mutated, 0 to 1.
    pub mutation_probability: f64,
    /// Best individuals carried over unchanged, less than the population.
    pub elitism: usize,
    /// Stop after this many evaluations, those of the initial grasp included.
    pub evaluation_limit: Option<u64>,
    /// Stop once this quality is reached.
    pub target_quality: Option<f64>,
}

/// State of the population after a generation; entry 0 is the initial population.
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
    pub stop: Stop,
    /// Whether it is proven that no exchange of one finger for any other candidate improves the best
    /// grasp by more than [`EXCHANGE_TOLERANCE`](super::EXCHANGE_TOLERANCE).
    pub single_exchange_optimal: bool,
    /// Other good force-closure grasps and their ε, the best first: optima of a memetic search, the last
    /// population of others; the best may be among them.
    pub others: Vec<(Grasp, f64)>,
}

/// An individual with its ε; `None` when it is not force closure, the paper's penalty, and when its
/// contacts do not keep their distances.
#[derive(Debug, Clone)]
struct Individual {
    ones: Grasp,
    quality: Option<f64>,
}

/// Individuals evaluated between two calls of the observer: with usual hulls some milliseconds, with
/// two of the largest allowed below a tenth of a second.
fn chunk_size(problem: &Problem) -> usize {
    (4096 / problem.effort()).clamp(2, 256)
}

/// Individuals made between two calls of the observer, before they are evaluated: some 10 ms.
const BROOD: usize = 4096;

/// Mutations of one child that are tried for one that keeps the distances.
const MUTATIONS: usize = 8;

/// Runs the algorithm from an optional first force-closure individual; the rest of the initial
/// population are random m-subsets, as far as possible such that [fit](Problem::fits). What does not fit
/// is not evaluated, and no outcome.
///
/// Each generation keeps the `elitism` best and fills up with children: parents win tournaments of
/// two on fitness −ε, pairs are crossed by Genetic Fix between two random cuts, children mutated by
/// exchanging a one with a zero. Individuals are evaluated in parallel on the current rayon pool;
/// every random number comes from a stream of its generation and pair, so the outcome does not
/// depend on the number of threads. `evaluations` is counted on.
pub fn modified_ga(
    problem: &Problem,
    settings: &GeneticSettings,
    seed: u64,
    first: Option<Grasp>,
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
        population: Vec::new(),
        best: None,
        history: Vec::new(),
    };
    let stop = match run.evolve(first) {
        Err(stop) => stop,
        Ok(()) => Stop::GenerationLimit,
    };
    run.close_history();
    run.outcome(stop)
}

/// The best of random grasps: as many a generation as the population has individuals, and nothing learnt
/// from one to the next. Limits, parallel work and history are those of [`modified_ga`].
pub fn random_search(
    problem: &Problem,
    settings: &GeneticSettings,
    seed: u64,
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
        population: Vec::new(),
        best: None,
        history: Vec::new(),
    };
    let stop = match run.sample() {
        Err(stop) => stop,
        Ok(()) => Stop::GenerationLimit,
    };
    run.close_history();
    run.outcome(stop)
}

struct Run<'a, 'o> {
    problem: &'a Problem,
    settings: &'a GeneticSettings,
    seed: u64,
    evaluations: &'a mut u64,
    interrupt: Interrupt<'o>,
    observe: Observer<'o>,
    population: Vec<Individual>,
    best: Option<(Grasp, f64)>,
    history: Vec<Generation>,
}

impl Run<'_, '_> {
    fn outcome(self, stop: Stop) -> Outcome {
        let mut others: Vec<(Grasp, f64)> = self
            .population
            .into_iter()
            .filter_map(|individual| Some((individual.ones, individual.quality?)))
            .collect();
        others.sort_by(|(_, a), (_, b)| rounded(*b).total_cmp(&rounded(*a)));
        Outcome {
            best: self.best,
            history: self.history,
            stop,
            single_exchange_optimal: false,
            others,
        }
    }

    fn evolve(&mut self, first: Option<Grasp>) -> Result<(), Stop> {
        let mut stream = Stream::new(self.seed, Purpose::Population, 0);
        let grasps = self.founders(first, &mut stream)?;
        self.evaluate(grasps)?;
        self.end_generation()?;
        for generation in 1..=self.settings.generations {
            self.population
                .sort_by(|a, b| fitness(a).total_cmp(&fitness(b)));
            let children = self.breed(generation as u64)?;
            self.population.truncate(self.settings.elitism);
            self.evaluate(children)?;
            self.end_generation()?;
        }
        Ok(())
    }

    fn sample(&mut self) -> Result<(), Stop> {
        for generation in 0..=self.settings.generations {
            let mut stream = Stream::new(self.seed, Purpose::Sample, generation as u64);
            let grasps = self.founders(None, &mut stream)?;
            self.population.clear();
            self.evaluate(grasps)?;
            self.end_generation()?;
        }
        Ok(())
    }

    /// A whole population: `first` and random grasps.
    fn founders(&mut self, first: Option<Grasp>, stream: &mut Stream) -> Result<Vec<Grasp>, Stop> {
        let (n, m) = (self.problem.len(), self.problem.contacts());
        let mut grasps: Vec<Grasp> = first.into_iter().collect();
        while grasps.len() < self.settings.population {
            if grasps.len().is_multiple_of(BROOD) {
                self.report(false)?;
            }
            let drawn = random_grasp(self.problem, stream, self.interrupt)?;
            grasps.push(drawn.unwrap_or_else(|| stream.subset(n, m)));
        }
        Ok(grasps)
    }

    /// Children to fill up the next generation, bred in parallel, each pair from its own stream.
    fn breed(&mut self, generation: u64) -> Result<Vec<Grasp>, Stop> {
        let &mut Self {
            problem,
            settings,
            seed,
            ..
        } = self;
        let wanted = settings.population - settings.elitism;
        let pairs = wanted.div_ceil(2);
        let mut children: Vec<Grasp> = Vec::with_capacity(2 * pairs);
        for from in (0..pairs).step_by(BROOD) {
            self.report(false)?;
            let population = &self.population;
            let brood = (from..pairs.min(from + BROOD)).into_par_iter();
            children.par_extend(brood.with_min_len(64).flat_map_iter(|pair| {
                let index = generation << 32 | pair as u64;
                let mut stream = Stream::new(seed, Purpose::Offspring, index);
                mate(problem, settings, population, &mut stream)
            }));
        }
        children.truncate(wanted);
        Ok(children)
    }

    /// Evaluates grasps and adds them to the population, as far as the search may go on.
    fn evaluate(&mut self, grasps: Vec<Grasp>) -> Result<(), Stop> {
        for chunk in grasps.chunks(chunk_size(self.problem)) {
            let left = match self.settings.evaluation_limit {
                Some(limit) => {
                    usize::try_from(limit.saturating_sub(*self.evaluations)).unwrap_or(usize::MAX)
                }
                None => usize::MAX,
            };
            let fitting: Vec<bool> = chunk.iter().map(|g| self.problem.fits(g)).collect();
            let mut evaluated = (0..chunk.len()).filter(|&i| fitting[i]);
            let allowed = &chunk[..evaluated.nth(left).unwrap_or(chunk.len())];
            let qualities: Vec<Option<f64>> = allowed
                .par_iter()
                .map_init(
                    || GraspEvaluator::new(self.problem),
                    |evaluator, grasp| evaluator.epsilon(grasp),
                )
                .collect();
            let fitting = fitting[..allowed.len()].iter().filter(|fits| **fits);
            *self.evaluations += fitting.count() as u64;
            for (grasp, quality) in allowed.iter().zip(qualities) {
                self.offer(grasp, quality);
                self.population.push(Individual {
                    ones: grasp.clone(),
                    quality,
                });
            }
            if allowed.len() < chunk.len() {
                return Err(Stop::EvaluationLimit);
            }
            self.report(false)?;
        }
        Ok(())
    }

    fn offer(&mut self, grasp: &Grasp, quality: Option<f64>) {
        if let Some(quality) = quality
            && self
                .best
                .as_ref()
                .is_none_or(|(_, best)| rounded(quality) > rounded(*best))
        {
            self.best = Some((grasp.clone(), quality));
        }
    }

    fn end_generation(&mut self) -> Result<(), Stop> {
        self.note_generation();
        self.report(true)
    }

    /// Enters the generation that the search was stopped in, as far as it had come.
    fn close_history(&mut self) {
        let known = self.history.last().map_or(0, |last| last.evaluations);
        if *self.evaluations > known && !self.population.is_empty() {
            self.note_generation();
        }
    }

    fn note_generation(&mut self) {
        let closed: Vec<f64> = self.population.iter().filter_map(|i| i.quality).collect();
        self.history.push(Generation {
            generation: self.history.len(),
            best: self.best.as_ref().map(|(_, quality)| *quality),
            mean: (!closed.is_empty()).then(|| closed.iter().sum::<f64>() / closed.len() as f64),
            force_closures: closed.len(),
            evaluations: *self.evaluations,
        });
    }

    fn report(&mut self, generation_ended: bool) -> Result<(), Stop> {
        let best = self.best.as_ref().map(|(_, quality)| *quality);
        let progress = Progress {
            phase: Phase::Search,
            generation: self.history.len().saturating_sub(1),
            evaluations: *self.evaluations,
            best,
            grasp: self.best.as_ref().map(|(grasp, _)| BestGrasp {
                problem: self.problem,
                grasp,
            }),
            generation_ended,
        };
        (self.observe)(&progress);
        self.interrupt.check()?;
        match (best, self.settings.target_quality) {
            (Some(best), Some(target)) if best >= target => Err(Stop::TargetQuality),
            _ => Ok(()),
        }
    }
}

/// Two children of two parents chosen from `population`. A parent takes the place of a child that does
/// not fit, and a mutation that never fits is left out.
fn mate(
    problem: &Problem,
    settings: &GeneticSettings,
    population: &[Individual],
    stream: &mut Stream,
) -> [Grasp; 2] {
    let n = problem.len();
    let parents = [(); 2].map(|()| &tournament(population, stream).ones);
    let [mut first, mut second] = parents.map(Grasp::clone);
    if stream.chance(settings.crossover_probability) {
        let cuts = stream.subset(n + 1, 2);
        genetic_fix(&mut first, &mut second, cuts[0], cuts[1]);
    }
    let mut children = [first, second];
    for (child, parent) in children.iter_mut().zip(parents) {
        if !problem.fits(child) {
            child.clone_from(parent);
        }
        if stream.chance(settings.mutation_probability) {
            let mutants = (0..MUTATIONS).map(|_| {
                let mut mutant = child.clone();
                mutate(&mut mutant, n, stream);
                mutant
            });
            let fitting = { mutants }.find(|mutant| problem.fits(mutant));
            *child = fitting.unwrap_or_else(|| child.clone());
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
