//! Local optimum search of Roa & Suárez (2009), the rival in the paper.

use super::exchange::{Climber, Exchange, Visit};
use super::genetic::{Generation, GeneticSettings, Outcome};
use super::problem::{Grasp, GraspEvaluator, Problem};
use super::progress::{BestGrasp, Observer, Phase, Progress, Stop};
use super::sites::Sites;
use crate::contact::Contact;
use crate::interrupt::Interrupt;
use crate::random::{Purpose, Stream};
use crate::wrench::WrenchSpace;

/// Evaluations of one visit to a slot.
const STEP: u64 = 16;

/// A contact whose wrenches come this near to the weakest facet, as a share of ε, lies on it. Intervals on ε are wider than that, and the upper end is what a
/// contact reaches.
const ON_FACET: f64 = 1e-6;

/// Improves a force-closure grasp, of ε `quality`, by one contact at a time.
///
/// The facet nearest to the origin is taken. For each contact on it the candidates are found that leave
/// the ball of radius ε inside the hull when they replace it, which is what no known facet of the hull of
/// the others forbids; the first of them, in random order, that makes the ball greater is taken, and the
/// search starts over from the new facet. It ends when no contact on the facet can be improved. One
/// generation of the history is one improvement; `settings` gives the limits only. `evaluations` is counted
/// on.
pub fn local(
    problem: &Problem,
    settings: &GeneticSettings,
    seed: u64,
    first: (Grasp, f64),
    evaluations: &mut u64,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) -> Outcome {
    let mut run = Run {
        problem,
        settings,
        climber: Climber::new(first.0, first.1),
        evaluations,
        interrupt,
        observe,
        history: Vec::new(),
    };
    let stop = match run.improve(&mut Stream::new(seed, Purpose::Local, 0)) {
        Err(stop) => stop,
        Ok(()) => Stop::LocalOptimum,
    };
    let mut grasp = run.climber.grasp;
    grasp.sort_unstable();
    Outcome {
        best: run.climber.quality.map(|quality| (grasp, quality)),
        history: run.history,
        stop,
        single_exchange_optimal: false,
        others: Vec::new(),
    }
}

struct Run<'a, 'o> {
    problem: &'a Problem,
    settings: &'a GeneticSettings,
    climber: Climber,
    evaluations: &'a mut u64,
    interrupt: Interrupt<'o>,
    observe: Observer<'o>,
    history: Vec<Generation>,
}

impl Run<'_, '_> {
    fn improve(&mut self, stream: &mut Stream) -> Result<(), Stop> {
        self.note(true)?;
        let sites = Sites::new(self.problem, self.interrupt)?;
        let mut exchange = Exchange::new(self.problem, &sites);
        let mut evaluator = GraspEvaluator::new(self.problem);
        loop {
            let slots = self.on_facet(&mut evaluator);
            let mut improved = false;
            for slot in slots {
                improved = self.exchange(&mut exchange, slot, stream)?;
                if improved {
                    break;
                }
            }
            if !improved {
                return Ok(());
            }
            self.note(true)?;
        }
    }

    /// The contacts that reach the weakest facet.
    fn on_facet(&self, evaluator: &mut GraspEvaluator<'_>) -> Vec<usize> {
        let Ok(margin) = evaluator.quality(&self.climber.grasp) else {
            return Vec::new();
        };
        let (problem, grasp) = (self.problem, &self.climber.grasp);
        let reach = |slot: usize| {
            let contact = Contact::from(problem.candidate(grasp[slot]));
            problem.model().reach(&contact, &margin.direction)
        };
        let reaches: Vec<f64> = (0..grasp.len()).map(reach).collect();
        // In L∞ every contact that reaches beyond zero holds the facet up.
        let near = match problem.model().space {
            WrenchSpace::L1 => margin.upper * (1.0 - ON_FACET),
            WrenchSpace::Linf => ON_FACET * margin.upper,
        };
        (0..grasp.len())
            .filter(|&slot| reaches[slot] >= near)
            .collect()
    }

    fn exchange(
        &mut self,
        exchange: &mut Exchange<'_>,
        slot: usize,
        stream: &mut Stream,
    ) -> Result<bool, Stop> {
        loop {
            let left = match self.settings.evaluation_limit {
                Some(limit) => limit.saturating_sub(*self.evaluations),
                None => u64::MAX,
            };
            if left == 0 {
                return Err(Stop::EvaluationLimit);
            }
            let most = left.min(STEP);
            let interrupt = self.interrupt;
            let visit = exchange.exchange(&mut self.climber, slot, most, Some(stream), interrupt);
            *self.evaluations += std::mem::take(&mut self.climber.evaluations);
            match visit? {
                Visit::Improved => return Ok(true),
                Visit::Proven => return Ok(false),
                Visit::Undecided => self.note(false)?,
            }
        }
    }

    fn progress(&self, generation_ended: bool) -> Progress<'static> {
        Progress {
            phase: Phase::Search,
            generation: self.history.len() - 1,
            evaluations: *self.evaluations,
            best: self.climber.quality,
            grasp: None,
            generation_ended,
        }
    }

    fn note(&mut self, generation_ended: bool) -> Result<(), Stop> {
        let best = self.climber.quality;
        if generation_ended {
            self.history.push(Generation {
                generation: self.history.len(),
                best,
                mean: best,
                force_closures: usize::from(best.is_some()),
                evaluations: *self.evaluations,
            });
        }
        let (problem, grasp) = (self.problem, &self.climber.grasp);
        let progress = Progress {
            grasp: best.map(|_| BestGrasp { problem, grasp }),
            ..self.progress(generation_ended)
        };
        (self.observe)(&progress);
        self.interrupt.check()?;
        match (best, self.settings.target_quality) {
            (Some(best), Some(target)) if best >= target => Err(Stop::TargetQuality),
            _ => Ok(()),
        }
    }
}
