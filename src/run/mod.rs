//! One planning run or the evaluation of given grasps as the outside sees it: request in, result out,
//! with clock and time limit.

mod analyses;
mod candidates;
mod constraints;
mod describe;
mod evaluate;
mod figures;
mod place;
mod report;
mod settings;
mod trials;
mod watch;

pub use evaluate::{EvaluationFault, evaluate};
pub use figures::figures;
pub use report::mesh_report;

use std::time::Duration;

use self::place::Place;
use self::watch::Watch;
use crate::wire::{
    CandidateSource, ContactPoint, FieldError, HistoryEntry, InitialGrasp, PlanRequest, PlanResult,
    Problem, Progress, TopGrasp,
};
use graspd_core::Interrupt;
use graspd_core::contact::Contact;
use graspd_core::mesh::Mesh;
use graspd_core::plan::{self, Mismatch, Plan, PlannedGrasp};
use graspd_core::search::Stop;
use graspd_core::top::distance;

/// Most entries of the history in a result, which so stays below some 200 KB.
const HISTORY_LIMIT: usize = 1000;

/// Plans a grasp on `mesh` with exactly the settings of `request`, on the current rayon pool.
///
/// `observe` is called many times a second with the state of the search. When `interrupt` comes, the run
/// stops and the result holds what was found so far, marked `cancelled`. The time limit of the
/// request is counted from the call, and anew from the end of the search, for the analyses of the grasp. Fails with a [`Problem`] only when the settings are out of
/// range or mesh and request do not fit together, such as more contacts than candidates.
///
/// More than one trial is made one after the other, and the best of them told.
pub fn plan(
    mesh: &Mesh,
    request: &PlanRequest,
    interrupt: Interrupt<'_>,
    observe: &mut (dyn FnMut(&Progress) + Send),
) -> Result<PlanResult, Problem> {
    match request.trials {
        0 | 1 => plan_once(mesh, request, interrupt, observe),
        _ => trials::plan(mesh, request, interrupt, observe),
    }
}

fn plan_once(
    mesh: &Mesh,
    request: &PlanRequest,
    interrupt: Interrupt<'_>,
    observe: &mut (dyn FnMut(&Progress) + Send),
) -> Result<PlanResult, Problem> {
    let watch = Watch::start(request, interrupt, observe);
    let mut settings = settings::settings(request)?;
    let (source, candidates_from) = candidates::source(mesh, &settings.wrench, request)?;
    settings.candidates = source;
    let mut fixed = Vec::new();
    if let Some(wanted) = &request.constraints {
        let model = settings.wrench.model(mesh)?;
        (settings.constraints, fixed) = constraints::constraints(mesh, &model, wanted)?;
    }
    let ask = || watch.interrupted();
    let mut report = |progress: &graspd_core::search::Progress<'_>| watch.report(progress);
    let plan = plan::plan(mesh, &settings, Interrupt::new(&ask), &mut report)?;
    let (elapsed, ended) = watch.end();
    Ok(result(
        request,
        candidates_from,
        &plan,
        &fixed,
        &ended,
        elapsed,
    ))
}

impl From<Mismatch> for Problem {
    fn from(mismatch: Mismatch) -> Self {
        let unfit = ("unfit-settings", "Settings that do not fit the mesh");
        let (field, (kind, title)) = match mismatch {
            Mismatch::TooFewCandidates { .. } => {
                ("contacts", ("too-few-candidates", "Too few candidates"))
            }
            Mismatch::FarCenter { .. } => ("center_of_mass", unfit),
            Mismatch::TorqueScale { .. } => ("torque_scale", unfit),
            Mismatch::Torsion { .. } => ("torsional_friction", unfit),
            Mismatch::Sigma { .. } => ("robustness/sigma", unfit),
        };
        let detail = mismatch.to_string();
        Self::new(422, kind, title, detail.as_str()).with_errors(vec![FieldError {
            pointer: format!("/{field}"),
            detail,
        }])
    }
}

fn result(
    request: &PlanRequest,
    candidates_from: CandidateSource,
    plan: &Plan,
    fixed: &[Place],
    ended: &[f64],
    elapsed: Duration,
) -> PlanResult {
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
        contacts: plan
            .best
            .as_ref()
            .map(|best| best_contacts(plan, fixed, best))
            .unwrap_or_default(),
        weakest_wrench: margin.map(|m| describe::weakest_wrench(&m, force_closure)),
        measures: plan.evaluation.as_ref().map(|e| e.measures),
        robustness: analysis.robustness,
        independent_regions: analysis.independent_regions,
        task_quality: analysis.task_quality,
        gravity_quality: analysis.gravity_quality,
        explanation: (!force_closure).then(|| describe::explanation(plan, request)),
        initial: plan.initial.as_ref().and_then(|grasp| {
            Some(InitialGrasp {
                quality: grasp.margin.ok()?.value,
                contacts: contacts(fixed, grasp),
            })
        }),
        frame: "mesh".to_owned(),
        units: request.units,
        torque_scale: describe::torque_scale(request.torque_scale, plan.model.torque_scale),
        center_of_mass: plan.model.center.into(),
        contact_model: request.contact_model,
        friction: request.friction,
        cone_edges: request.cone_edges,
        torsional_friction: describe::torsion(&plan.model),
        edge_norm: request.edge_norm,
        wrench_space: request.wrench_space,
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
        reproducible: !matches!(plan.stop, Stop::TimeLimit | Stop::Cancelled),
        evaluations: plan.evaluations,
        history: history(plan, ended, elapsed),
        elapsed_s: elapsed.as_secs_f64(),
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
fn best_contacts(plan: &Plan, fixed: &[Place], best: &PlannedGrasp) -> Vec<ContactPoint> {
    let effort = plan.evaluation.as_ref().and_then(|e| e.weakest.as_ref());
    let mut contacts = contacts(fixed, best);
    for (i, contact) in contacts.iter_mut().enumerate() {
        if let Some((force, torsion)) = describe::contact_force(&plan.model, effort, i) {
            (contact.forces, contact.torsion) = (Some(force), torsion);
        }
    }
    contacts
}

/// The distinct grasps of the plan.
fn top(plan: &Plan, fixed: &[Place]) -> Vec<TopGrasp> {
    let first = plan.top.first().map_or(&[][..], |best| &best.contacts);
    let told = plan.top.iter().filter_map(|grasp| {
        Some(TopGrasp {
            quality: grasp.margin.ok()?.value,
            distance_to_best: distance(first, &grasp.contacts),
            contacts: contacts(fixed, grasp),
        })
    });
    told.collect()
}

/// The fixed contacts, then the planned ones.
fn contacts(fixed: &[Place], grasp: &PlannedGrasp) -> Vec<ContactPoint> {
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
