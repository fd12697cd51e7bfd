//! The polish of a planning run: the contacts of the best grasp slide over the surface.

use super::outcome::{PlannedGrasp, Polish};
use super::run::Run;
use crate::mesh::{Candidate, Surface, SurfaceContact};
use crate::search::{Phase, PolishSettings, SearchProblem, StopReason, polish};

/// Wrenches that a polish evaluates: 300 grasps of 4 contacts with 8 edges, some milliseconds.
const POLISHED_WRENCHES: u64 = 300 * 32;

/// Most evaluations of a polish.
const MOST_EVALUATIONS: u64 = 300;

/// Fewer evaluations are not worth the start of a polish: beyond some 15 contacts with 32 edges there is none.
const LEAST_EVALUATIONS: u64 = 20;

/// Slides the contacts of the best grasp. The time limit, which may have ended the search, is ignored:
/// this takes some milliseconds.
pub(super) fn polish_best(run: &mut Run<'_>, problem: &SearchProblem) {
    let affordable = POLISHED_WRENCHES / problem.evaluation_cost() as u64;
    let most = affordable.min(MOST_EVALUATIONS).min(run.budget.left());
    let is_force_closure = run
        .plan
        .best
        .as_ref()
        .is_some_and(|best| best.force_closure);
    if !is_force_closure || most < LEAST_EVALUATIONS {
        return;
    }
    run.report(Phase::Search);
    let (mesh, interrupt) = (run.mesh, run.interrupt.ignoring_time_limit());
    let surface = match Surface::interruptible(mesh, interrupt) {
        Ok(surface) => surface,
        Err(why) => {
            run.plan.stop = why.into();
            return;
        }
    };
    let best = run.plan.best.iter().flat_map(|best| &best.contacts);
    let start = best.map(|contact| {
        let index = mesh.source().binary_search(&contact.triangle).ok()?;
        surface.place(index, contact.barycentric)
    });
    let Some(start) = start.collect::<Option<Vec<SurfaceContact>>>() else {
        return;
    };
    let constraints = &run.settings.constraints;
    let polished = polish(
        &surface,
        problem.model(),
        &constraints.fixed,
        &start,
        PolishSettings {
            evaluation_limit: most,
        },
        &|places| {
            let exposed =
                |place: &SurfaceContact| mesh.is_exposed(place.triangle, &place.barycentric);
            places.iter().all(exposed) && constraints.allow(&candidates_at(places))
        },
        interrupt,
    );
    let Ok(polished) = polished else {
        return;
    };
    run.budget.spend(polished.evaluations);
    let plan = &mut run.plan;
    plan.stop = polished.stopped.map_or(plan.stop, StopReason::from);
    plan.polish = Some(Polish {
        quality_before: polished.margin.value - polished.gain,
        gain: polished.gain,
        evaluations: polished.evaluations,
    });
    if polished.gain > 0.0 {
        plan.best = Some(PlannedGrasp {
            contacts: candidates_at(&polished.contacts),
            margin: Ok(polished.margin),
            force_closure: problem.passes_closure_floor(&polished.margin),
        });
    }
}

fn candidates_at(places: &[SurfaceContact]) -> Vec<Candidate> {
    let candidate = |place: &SurfaceContact| Candidate {
        position: place.position,
        normal: place.normal,
        triangle: place.source,
        barycentric: place.barycentric,
    };
    places.iter().map(candidate).collect()
}
