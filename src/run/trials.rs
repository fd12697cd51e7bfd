//! Trials: a run repeated with consecutive seeds.

use std::time::Instant;

use super::plan_once;
use crate::wire::{PlanRequest, PlanResult, Problem, Progress, Statistics, Trial, Trials};
use graspd_core::Interrupt;
use graspd_core::contact::Contact;
use graspd_core::mesh::Mesh;
use graspd_core::search::StopReason;

/// Runs the trials one after the other and returns the best result, the first among equals, with statistics
/// over all of them. The time limit of the request applies to all trials together. Every trial makes the
/// analyses that the request asks for; the result keeps those of the best.
pub(super) fn plan(
    mesh: &Mesh,
    request: &PlanRequest,
    interrupt: Interrupt<'_>,
    observe: &mut (dyn FnMut(&Progress) + Send),
) -> Result<PlanResult, Problem> {
    let clock = Instant::now();
    let mut runs = Vec::new();
    let mut best: Option<PlanResult> = None;
    let mut earlier = Earlier::default();
    for trial in 0..u64::from(request.trials) {
        let spent = clock.elapsed().as_secs_f64();
        let left = request.time_limit_s.map(|limit| limit - spent);
        if trial > 0 && left.is_some_and(|left| left <= 0.0) {
            break;
        }
        let one = PlanRequest {
            seed: request.seed.wrapping_add(trial),
            time_limit_s: left,
            ..request.clone()
        };
        let result = plan_once(mesh, &one, interrupt, &mut |progress| {
            let together = earlier.with(progress, trial, request.trials);
            observe(&Progress {
                elapsed_s: clock.elapsed().as_secs_f64(),
                ..together
            });
        })?;
        earlier.evaluations += result.evaluations;
        runs.push(Trial {
            seed: result.seed,
            initial: result.initial.as_ref().map(|grasp| grasp.quality),
            last: result.quality,
            evaluations: result.evaluations,
            stopped_because: result.stopped_because,
            elapsed_s: result.elapsed_s,
        });
        let cancelled = result.stopped_because == StopReason::Cancelled;
        let is_better = |best: &PlanResult| rank(&result) > rank(best);
        if best.as_ref().is_none_or(is_better) {
            best = Some(result);
        }
        if cancelled {
            break;
        }
    }
    let Some(best) = best else {
        return plan_once(mesh, request, interrupt, observe);
    };
    Ok(PlanResult {
        reproducible: runs.iter().all(|run| {
            !matches!(
                run.stopped_because,
                StopReason::TimeLimit | StopReason::Cancelled
            )
        }) && runs.len() == request.trials as usize,
        evaluations: runs.iter().map(|run| run.evaluations).sum(),
        elapsed_s: clock.elapsed().as_secs_f64(),
        trials: Some(statistics(runs)),
        ..best
    })
}

/// The contribution of earlier trials to the progress of the one that runs.
#[derive(Default)]
struct Earlier {
    /// Evaluations of the trials that have ended.
    evaluations: u64,
    /// The best quality of all trials so far, with the contacts that have it.
    best: Option<(f64, Option<Vec<Contact>>)>,
}

impl Earlier {
    /// The progress of all trials together, when trial `number` (from 0) has the progress `one`.
    fn with(&mut self, one: &Progress, number: u64, trials: u32) -> Progress {
        if let Some(quality) = one.best_quality
            && self.best.as_ref().is_none_or(|(best, _)| quality >= *best)
        {
            self.best = Some((quality, one.best_contacts.clone()));
        }
        let (best_quality, best_contacts) = self.best.clone().unzip();
        Progress {
            generation: number * one.generations + one.generation,
            generations: u64::from(trials) * one.generations,
            evaluations: self.evaluations + one.evaluations,
            best_quality,
            best_contacts: best_contacts.flatten(),
            ..one.clone()
        }
    }
}

/// Ranks a result: force closure first, then the margin.
fn rank(result: &PlanResult) -> (bool, f64) {
    let margin = result.margin.unwrap_or(f64::NEG_INFINITY);
    (result.force_closure, margin)
}

fn statistics(runs: Vec<Trial>) -> Trials {
    let ratios = runs.iter().filter_map(|run| Some(run.last? / run.initial?));
    Trials {
        count: runs.len() as u32,
        force_closures: runs.iter().filter(|run| run.last.is_some()).count() as u32,
        initial: Statistics::of(runs.iter().filter_map(|run| run.initial)),
        last: Statistics::of(runs.iter().filter_map(|run| run.last)),
        ratio: Statistics::of(ratios),
        evaluations: Statistics::of(runs.iter().map(|run| run.evaluations as f64)),
        elapsed_s: Statistics::of(runs.iter().map(|run| run.elapsed_s)),
        runs,
    }
}
