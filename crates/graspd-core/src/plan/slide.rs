//! The polish at the end of a run: the contacts of the best grasp slide.

use super::{Plan, PlannedGrasp, Polish, Settings, progress};
use crate::interrupt::Interrupt;
use crate::mesh::{Candidate, Mesh, Surface, SurfaceContact};
use crate::search::{Observer, Phase, PolishSettings, Problem, Progress, Stop, polish};

/// Wrenches that a polish evaluates: 300 grasps of 4 contacts with 8 edges, and some milliseconds.
const POLISHED_WRENCHES: u64 = 300 * 32;

/// Fewer evaluations are not worth the start of a polish: beyond some 15 contacts with 32 edges there is none.
const LEAST_POLISH: u64 = 20;

/// Slides the contacts of the best grasp. The time limit, which may have ended the search, is not looked at:
/// this takes some milliseconds.
pub(super) fn slide(
    plan: &mut Plan,
    mesh: &Mesh,
    problem: &Problem,
    settings: &Settings,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) {
    let Some(best) = plan.best.as_ref().filter(|best| best.force_closure) else {
        return;
    };
    let left = match settings.genetic.evaluation_limit {
        Some(limit) => limit.saturating_sub(plan.evaluations),
        None => u64::MAX,
    };
    let most = POLISHED_WRENCHES / problem.effort() as u64;
    let evaluation_limit = most.min(300).min(left);
    if evaluation_limit < LEAST_POLISH {
        return;
    }
    observe(&Progress {
        best: best.margin.as_ref().ok().map(|margin| margin.value),
        ..progress(plan, Phase::Search)
    });
    let interrupt = interrupt.ignoring_time_limit();
    let surface = match Surface::interruptible(mesh, interrupt) {
        Ok(surface) => surface,
        Err(why) => {
            plan.stop = why.into();
            return;
        }
    };
    let start = best.contacts.iter().map(|contact| {
        let index = mesh.source().binary_search(&contact.triangle).ok()?;
        surface.place(index, contact.barycentric)
    });
    let Some(start) = start.collect::<Option<Vec<SurfaceContact>>>() else {
        return;
    };
    let constraints = &settings.constraints;
    let polished = polish(
        &surface,
        problem.model(),
        &constraints.fixed,
        &start,
        PolishSettings { evaluation_limit },
        &|places| constraints.allow(&candidates_at(places)),
        interrupt,
    );
    let Ok(polished) = polished else {
        return;
    };
    plan.evaluations += polished.evaluations;
    plan.stop = polished.stopped.map_or(plan.stop, Stop::from);
    let quality_before = polished.margin.value - polished.gain;
    plan.polish = Some(Polish {
        quality_before,
        gain: polished.gain,
        evaluations: polished.evaluations,
    });
    if polished.gain > 0.0 {
        plan.best = Some(PlannedGrasp {
            contacts: candidates_at(&polished.contacts),
            margin: Ok(polished.margin),
            force_closure: problem.closes(&polished.margin),
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
