//! The search of a planning run: the first grasp, the best one, or the reason why there is none.

use super::outcome::{Infeasible, PlannedGrasp};
use super::run::Run;
use crate::search::{
    AllGrasps, Grasp, Impossible, Initial, Method, Phase, Search, SearchProblem, StopReason,
    exhaustive_search, initial_grasp, nearest_start, prove_impossible,
};

/// Searches the best grasp. Returns other good ones that were found, with their ε, the best first.
pub(super) fn search_best(run: &mut Run<'_>, problem: &SearchProblem) -> Vec<(Grasp, f64)> {
    let settings = run.settings;
    let Some(first) = first_grasp(run, problem) else {
        return Vec::new();
    };
    let initial = first.as_ref();
    run.plan.initial = initial.map(|(grasp, _)| PlannedGrasp::new(problem, grasp));
    if let (Some((_, quality)), Some(target)) = (initial, settings.search.target_quality)
        && *quality >= target
    {
        run.plan.stop = StopReason::TargetQuality;
        run.plan.best = run.plan.initial.clone();
        return Vec::new();
    }
    let search = Search {
        problem,
        settings: &settings.search,
        seed: settings.seed,
        budget: &mut run.budget,
        interrupt: run.interrupt,
        observe: &mut *run.observe,
    };
    let outcome = search.run(settings.method, first.clone());
    run.plan.history = outcome.history;
    run.plan.stop = outcome.stop;
    run.plan.single_exchange_optimal = outcome.single_exchange_optimal;
    let mut best = better(first, outcome.best);
    // A search that ran its course and found nothing leaves open whether there is a grasp.
    if best.is_none() && run.plan.stop == StopReason::GenerationLimit {
        best = look_at_all(run, problem);
    }
    if best.is_none() && run.plan.stop == StopReason::GenerationLimit && run.budget.spent() == 0 {
        let planned = problem.contacts();
        run.set_infeasible(Infeasible::NoneFits { planned });
    }
    run.plan.best = match best {
        Some(grasp) => Some(PlannedGrasp::new(problem, &grasp)),
        None => nearest(run, problem),
    };
    outcome.others
}

/// Returns the grasp of Algorithm 1, where the method starts from one and it was found. `None` when the run is over,
/// with the reason in the plan.
fn first_grasp(run: &mut Run<'_>, problem: &SearchProblem) -> Option<Option<(Grasp, f64)>> {
    let settings = run.settings;
    let initial = if settings.method == Method::Random {
        match prove_impossible(problem, run.interrupt) {
            Ok(Some(proof)) => Initial::Impossible(proof),
            Ok(None) => Initial::NotFound,
            Err(why) => Initial::Stopped(why.into()),
        }
    } else {
        initial_grasp(
            problem,
            settings.initial,
            settings.seed,
            &mut run.budget,
            run.interrupt,
            &mut *run.observe,
        )
    };
    match initial {
        Initial::Found { grasp, quality } => return Some(Some((grasp, quality))),
        Initial::NotFound => return Some(None),
        Initial::NoneFits => {
            let planned = problem.contacts();
            run.set_infeasible(Infeasible::NoneFits { planned });
        }
        Initial::Impossible(proof) => {
            run.plan.impossible = Some(proof);
            run.plan.best = nearest(run, problem);
        }
        Initial::Stopped(stop) => run.plan.stop = stop,
    }
    None
}

/// Evaluates all grasps of a small problem, and notes the proof when none is force closure.
fn look_at_all(run: &mut Run<'_>, problem: &SearchProblem) -> Option<Grasp> {
    run.report(Phase::Search);
    match exhaustive_search(problem, &mut run.budget, run.interrupt) {
        Ok(Some(AllGrasps { grasps, best: None })) => {
            run.plan.impossible = Some(Impossible::Exhausted { grasps });
            run.plan.stop = StopReason::Impossible;
            None
        }
        Ok(found) => found?.best.map(|(grasp, _)| grasp),
        Err(why) => {
            run.plan.stop = why.into();
            None
        }
    }
}

/// Returns the better of two grasps, the second when they are equal.
fn better(first: Option<(Grasp, f64)>, second: Option<(Grasp, f64)>) -> Option<Grasp> {
    match (first, second) {
        (Some((a, first)), Some((b, second))) => Some(if second >= first { b } else { a }),
        (a, b) => a.or(b).map(|(grasp, _)| grasp),
    }
}

/// Returns a grasp to show when none is force closure; none when the run is to stop at once.
fn nearest(run: &mut Run<'_>, problem: &SearchProblem) -> Option<PlannedGrasp> {
    run.report(Phase::Search);
    let grasp = nearest_start(problem, run.settings.seed, run.interrupt)?;
    Some(PlannedGrasp::new(problem, &grasp))
}
