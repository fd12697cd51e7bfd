//! From what the planner found to the result of a run.

use std::time::Duration;

use super::place::PlacedContact;
use super::{analyses, explain};
use crate::wire::{
    ContactPoint, HistoryEntry, InitialGrasp, PlanRequest, PlanResult, SearchedCandidates, TopGrasp,
};
use graspd_core::contact::Contact;
use graspd_core::diverse::distance;
use graspd_core::plan::{ContactFields, Plan, PlannedGrasp};
use graspd_core::search::StopReason;

/// Most entries of the history in a result, which so stays below some 200 KB.
const HISTORY_LIMIT: usize = 1000;

/// The result of one run. `fixed` are the places of the fixed contacts, `ended` the seconds at which each
/// generation ended.
pub(super) fn result(
    request: &PlanRequest,
    candidates_from: SearchedCandidates,
    plan: &Plan,
    fixed: &[PlacedContact],
    ended: &[f64],
    elapsed: Duration,
) -> PlanResult {
    let wrench = &request.quality.wrench;
    let contact = ContactFields::from(wrench.contact);
    let margin = plan.best.as_ref().and_then(|grasp| grasp.margin.ok());
    let force_closure = plan.best.as_ref().is_some_and(|grasp| grasp.force_closure);
    let mut analysis = plan.analysis.clone().unwrap_or_default();
    analyses::shorten(&mut analysis.independent_regions, 1);
    PlanResult {
        force_closure,
        quality: margin.filter(|_| force_closure).map(|m| m.value),
        margin: margin.map(|m| m.value),
        exact: margin.map(|m| m.exact),
        bounds: plan.evaluation.as_ref().and_then(|e| e.bounds),
        bounds_exact: plan.evaluation.as_ref().and_then(|e| e.bounds_exact),
        contacts: plan
            .best
            .as_ref()
            .map(|best| best_contacts(plan, fixed, best))
            .unwrap_or_default(),
        weakest_wrench: margin.map(|m| explain::weakest_wrench(&m, force_closure)),
        measures: plan.evaluation.as_ref().map(|e| e.measures),
        robustness: analysis.robustness,
        independent_regions: analysis.independent_regions,
        task_quality: analysis.task_quality,
        gravity_quality: analysis.gravity_quality,
        explanation: (!force_closure).then(|| explain::explanation(plan, request)),
        initial: plan.initial.as_ref().and_then(|grasp| {
            Some(InitialGrasp {
                quality: grasp.margin.ok()?.value,
                contacts: contacts(fixed, grasp),
            })
        }),
        frame: "mesh".to_owned(),
        units: request.quality.units,
        torque_scale: explain::torque_scale(wrench.torque_scale, plan.model.torque_scale),
        center_of_mass: plan.model.center.into(),
        contact_model: contact.contact_model,
        friction: contact.friction,
        cone_edges: contact.cone_edges,
        torsional_friction: explain::torsion(&plan.model),
        edge_norm: wrench.edge_norm,
        wrench_space: wrench.space,
        candidates: plan.candidates as u64,
        candidates_from: Some(candidates_from),
        constraints: request.constraints.as_ref().map(|_| plan.removals.clone()),
        method: request.method,
        seed: request.seed,
        stopped_because: plan.stop,
        trials: None,
        top: (request.top > 1).then(|| top(plan, fixed)),
        polish: plan.polish,
        single_exchange_optimal: plan.single_exchange_optimal,
        reproducible: !matches!(plan.stop, StopReason::TimeLimit | StopReason::Cancelled),
        evaluations: plan.evaluations,
        history: history(plan, ended, elapsed),
        elapsed_s: elapsed.as_secs_f64(),
        mesh_warnings: Vec::new(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    }
}

/// The history with its times, thinned evenly to [`HISTORY_LIMIT`] entries, first and last kept.
fn history(plan: &Plan, ended: &[f64], elapsed: Duration) -> Vec<HistoryEntry> {
    let count = plan.history.len();
    let shown = count.min(HISTORY_LIMIT);
    (0..shown)
        .map(|i| {
            if i + 1 == shown {
                count - 1
            } else {
                i * count / shown
            }
        })
        .map(|i| {
            let generation = &plan.history[i];
            HistoryEntry {
                generation: generation.generation as u64,
                best: generation.best,
                mean: generation.mean,
                force_closures: generation.force_closures as u64,
                evaluations: generation.evaluations,
                // A generation that the search was stopped in has no end of its own.
                elapsed_s: ended.get(i).copied().unwrap_or(elapsed.as_secs_f64()),
            }
        })
        .collect()
}

/// The contacts of the best grasp, with the forces against its worst disturbance.
fn best_contacts(plan: &Plan, fixed: &[PlacedContact], best: &PlannedGrasp) -> Vec<ContactPoint> {
    let effort = plan.evaluation.as_ref().and_then(|e| e.weakest.as_ref());
    let mut contacts = contacts(fixed, best);
    for (i, contact) in contacts.iter_mut().enumerate() {
        if let Some((force, torsion)) = explain::contact_force(&plan.model, effort, i) {
            (contact.forces, contact.torsion) = (Some(force), torsion);
        }
    }
    contacts
}

/// The distinct grasps of the plan.
fn top(plan: &Plan, fixed: &[PlacedContact]) -> Vec<TopGrasp> {
    let first = plan.top.first().map_or(&[][..], |best| &best.contacts);
    let given = fixed.iter().map(|place| place.site.contact.position);
    let given: Vec<_> = given.collect();
    let grasps = plan.top.iter().filter_map(|grasp| {
        Some(TopGrasp {
            quality: grasp.margin.ok()?.value,
            distance_to_best: distance(first, &grasp.contacts, &given),
            contacts: contacts(fixed, grasp),
        })
    });
    grasps.collect()
}

/// The fixed contacts, then the planned ones.
fn contacts(fixed: &[PlacedContact], grasp: &PlannedGrasp) -> Vec<ContactPoint> {
    let fixed = fixed.iter().map(|place| ContactPoint {
        triangle: place.site.triangle,
        barycentric: place.barycentric,
        fixed: true,
        ..contact(&place.site.contact)
    });
    let planned = grasp.contacts.iter().map(|candidate| ContactPoint {
        triangle: Some(candidate.triangle),
        barycentric: Some(candidate.barycentric),
        ..contact(&candidate.into())
    });
    fixed.chain(planned).collect()
}

fn contact(contact: &Contact) -> ContactPoint {
    let normal = contact.normal.into_inner();
    ContactPoint {
        position: contact.position.into(),
        normal: normal.into(),
        approach: (-normal).into(),
        triangle: None,
        barycentric: None,
        fixed: false,
        forces: None,
        torsion: None,
    }
}
