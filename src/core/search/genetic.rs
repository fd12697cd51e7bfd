//! The paper's modified genetic algorithm (paper, §3.3 and §3.4).

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::crossover::{genetic_fix, mutate};
use super::problem::{Grasp, GraspEvaluator, Problem};
use super::progress::{Observer, Phase, Progress, Stop};
use super::random::{Purpose, Stream};

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
}

/// An individual with its ε; `None` when it is not force closure, the paper's penalty.
#[derive(Debug, Clone)]
struct Individual {
    ones: Grasp,
    quality: Option<f64>,
}

/// Individuals evaluated between two calls of the observer, so that hulls of 32 wrenches give it
/// some hundred calls a second and those of 2,048 still ten.
fn chunk_size(wrenches: usize) -> usize {
    (4096 / wrenches).clamp(8, 256)
}

/// Runs the algorithm from an optional first force-closure individual; the rest of the initial
/// population are random m-subsets.
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
    observe: Observer<'_>,
) -> Outcome {
    let mut run = Run {
        problem,
        settings,
        seed,
        evaluations,
        observe,
        best: None,
        history: Vec::new(),
    };
    let stop = match run.evolve(first) {
        ControlFlow::Break(stop) => stop,
        ControlFlow::Continue(()) => Stop::GenerationLimit,
    };
    Outcome {
        best: run.best,
        history: run.history,
        stop,
    }
}

struct Run<'a, 'o> {
    problem: &'a Problem,
    settings: &'a GeneticSettings,
    seed: u64,
    evaluations: &'a mut u64,
    observe: Observer<'o>,
    best: Option<(Grasp, f64)>,
    history: Vec<Generation>,
}

impl Run<'_, '_> {
    fn evolve(&mut self, first: Option<Grasp>) -> ControlFlow<Stop> {
        let (n, m) = (self.problem.len(), self.problem.contacts());
        let mut stream = Stream::new(self.seed, Purpose::Population, 0);
        let mut grasps: Vec<Grasp> = first.into_iter().collect();
        while grasps.len() < self.settings.population {
            grasps.push(stream.subset(n, m));
        }
        let mut population = Vec::new();
        self.evaluate(grasps, &mut population)?;
        self.end_generation(0, &population)?;
        for generation in 1..=self.settings.generations {
            population.sort_by(|a: &Individual, b| fitness(a).total_cmp(&fitness(b)));
            let children = self.breed(generation as u64, &population);
            population.truncate(self.settings.elitism);
            self.evaluate(children, &mut population)?;
            self.end_generation(generation, &population)?;
        }
        ControlFlow::Continue(())
    }

    /// Children to fill up the next generation.
    fn breed(&self, generation: u64, population: &[Individual]) -> Vec<Grasp> {
        let wanted = self.settings.population - self.settings.elitism;
        let n = self.problem.len();
        let mut children = Vec::with_capacity(wanted + 1);
        while children.len() < wanted {
            let pair = children.len() as u64 / 2;
            let mut stream = Stream::new(self.seed, Purpose::Offspring, generation << 32 | pair);
            let mut first = tournament(population, &mut stream).ones.clone();
            let mut second = tournament(population, &mut stream).ones.clone();
            if stream.chance(self.settings.crossover_probability) {
                let cuts = stream.subset(n + 1, 2);
                genetic_fix(&mut first, &mut second, cuts[0], cuts[1]);
            }
            for mut child in [first, second] {
                if stream.chance(self.settings.mutation_probability) {
                    mutate(&mut child, n, &mut stream);
                }
                children.push(child);
            }
        }
        children.truncate(wanted);
        children
    }

    /// Evaluates grasps and adds them to the population, as far as the search may go on.
    fn evaluate(
        &mut self,
        grasps: Vec<Grasp>,
        population: &mut Vec<Individual>,
    ) -> ControlFlow<Stop> {
        for chunk in grasps.chunks(chunk_size(self.problem.wrenches_per_grasp())) {
            let left = match self.settings.evaluation_limit {
                Some(limit) => {
                    usize::try_from(limit.saturating_sub(*self.evaluations)).unwrap_or(usize::MAX)
                }
                None => usize::MAX,
            };
            let allowed = &chunk[..chunk.len().min(left)];
            let qualities: Vec<Option<f64>> = allowed
                .par_iter()
                .map_init(
                    || GraspEvaluator::new(self.problem),
                    |evaluator, grasp| evaluator.epsilon(grasp),
                )
                .collect();
            *self.evaluations += allowed.len() as u64;
            for (grasp, quality) in allowed.iter().zip(qualities) {
                self.offer(grasp, quality);
                population.push(Individual {
                    ones: grasp.clone(),
                    quality,
                });
            }
            if allowed.len() < chunk.len() {
                return ControlFlow::Break(Stop::EvaluationLimit);
            }
            self.report(false)?;
        }
        ControlFlow::Continue(())
    }

    fn offer(&mut self, grasp: &Grasp, quality: Option<f64>) {
        if let Some(quality) = quality
            && self.best.as_ref().is_none_or(|(_, best)| quality > *best)
        {
            self.best = Some((grasp.clone(), quality));
        }
    }

    fn end_generation(
        &mut self,
        generation: usize,
        population: &[Individual],
    ) -> ControlFlow<Stop> {
        let closed: Vec<f64> = population.iter().filter_map(|i| i.quality).collect();
        self.history.push(Generation {
            generation,
            best: self.best.as_ref().map(|(_, quality)| *quality),
            mean: (!closed.is_empty()).then(|| closed.iter().sum::<f64>() / closed.len() as f64),
            force_closures: closed.len(),
            evaluations: *self.evaluations,
        });
        self.report(true)
    }

    fn report(&mut self, generation_ended: bool) -> ControlFlow<Stop> {
        let best = self.best.as_ref().map(|(_, quality)| *quality);
        let progress = Progress {
            phase: Phase::Search,
            generation: self.history.len().saturating_sub(1),
            evaluations: *self.evaluations,
            best,
            generation_ended,
        };
        (self.observe)(&progress)?;
        match (best, self.settings.target_quality) {
            (Some(best), Some(target)) if best >= target => ControlFlow::Break(Stop::TargetQuality),
            _ => ControlFlow::Continue(()),
        }
    }
}

/// −ε, and a penalty above every −ε when there is no force closure (paper, §3.3.1).
fn fitness(individual: &Individual) -> f64 {
    individual.quality.map_or(1.0, |quality| -quality)
}

/// The fitter of two random individuals.
fn tournament<'p>(population: &'p [Individual], stream: &mut Stream) -> &'p Individual {
    let a = &population[stream.below(population.len())];
    let b = &population[stream.below(population.len())];
    if fitness(b) < fitness(a) { b } else { a }
}
