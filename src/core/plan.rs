//! One planning run: validated settings and a mesh in, the best grasp found and its proof out.

use nalgebra::Point3;

use super::contact::ContactModel;
use super::mesh::{Candidate, Mesh};
use super::quality::{Degenerate, Evaluator, Margin};
use super::search::{
    Generation, GeneticSettings, Grasp, Impossible, Initial, InitialMode, Observer, Problem, Stop,
    initial_grasp, modified_ga, nearest_start,
};
use super::wrench::{EdgeNorm, TorqueScale, WrenchModel};

/// What to plan. Every field is validated before it gets here.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Number of contacts m, 1 to [`super::contact::MAX_CONTACTS`].
    pub contacts: usize,
    pub contact_model: ContactModel,
    pub edge_norm: EdgeNorm,
    pub torque_scale: TorqueScale,
    /// Torques are taken about this point; `None` means the mesh's centre of mass.
    pub center_of_mass: Option<Point3<f64>>,
    pub initial: InitialMode,
    pub genetic: GeneticSettings,
    pub seed: u64,
}

/// A grasp with its exact evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedGrasp {
    pub contacts: Vec<Candidate>,
    /// Where the origin stands in the hull of the grasp's wrenches, or why they have none.
    pub margin: Result<Margin, Degenerate>,
}

/// What a planning run found.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The point torques are taken about.
    pub center: Point3<f64>,
    /// The number λ, 1/length.
    pub torque_scale: f64,
    /// Number of candidates n that were searched.
    pub candidates: usize,
    /// The first force-closure grasp, found by Algorithm 1.
    pub initial: Option<PlannedGrasp>,
    /// The best force-closure grasp, or, when none was found, the random grasp nearest to it.
    pub best: Option<PlannedGrasp>,
    pub history: Vec<Generation>,
    pub evaluations: u64,
    pub stop: Stop,
    /// The proof that no force-closure grasp exists, when there is one.
    pub impossible: Option<Impossible>,
}

/// There are fewer candidates than contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "{contacts} contacts need as many places to put them, but the mesh has only {candidates} \
     candidates"
)]
pub struct TooFewCandidates {
    pub contacts: usize,
    pub candidates: usize,
}

/// Finds an initial force-closure grasp and improves it, on the current rayon pool.
///
/// The same mesh, settings and seed give the same plan on any number of threads, unless `observe`
/// breaks off at a time of its own.
pub fn plan(
    mesh: &Mesh,
    settings: &Settings,
    observe: Observer<'_>,
) -> Result<Plan, TooFewCandidates> {
    let center = settings
        .center_of_mass
        .unwrap_or(mesh.report().center_of_mass);
    let model = WrenchModel {
        contact_model: settings.contact_model,
        edge_norm: settings.edge_norm,
        center,
        torque_scale: settings.torque_scale.value(mesh, &center),
    };
    let candidates = mesh.candidates();
    let too_few = TooFewCandidates {
        contacts: settings.contacts,
        candidates: candidates.len(),
    };
    let problem = Problem::new(candidates, model, settings.contacts).ok_or(too_few)?;
    Ok(search(&problem, settings, observe))
}

fn search(problem: &Problem, settings: &Settings, observe: Observer<'_>) -> Plan {
    let seed = settings.seed;
    let mut plan = Plan {
        center: problem.model().center,
        torque_scale: problem.model().torque_scale,
        candidates: problem.len(),
        initial: None,
        best: None,
        history: Vec::new(),
        evaluations: 0,
        stop: Stop::Impossible,
        impossible: None,
    };
    let initial = initial_grasp(
        problem,
        settings.initial,
        seed,
        &mut plan.evaluations,
        &mut *observe,
    );
    let first = match initial {
        Initial::Found { grasp, quality } => Some((grasp, quality)),
        Initial::NotFound => None,
        Initial::Impossible(proof) => {
            plan.impossible = Some(proof);
            plan.best = nearest(problem, seed);
            return plan;
        }
        Initial::Stopped(stop) => {
            plan.stop = stop;
            return plan;
        }
    };
    plan.initial = first.as_ref().map(|(grasp, _)| evaluated(problem, grasp));
    let outcome = modified_ga(
        problem,
        &settings.genetic,
        seed,
        first.as_ref().map(|(grasp, _)| grasp.clone()),
        &mut plan.evaluations,
        observe,
    );
    plan.history = outcome.history;
    plan.stop = outcome.stop;
    plan.best = match better(first, outcome.best) {
        Some(grasp) => Some(evaluated(problem, &grasp)),
        None => nearest(problem, seed),
    };
    plan
}

fn better(first: Option<(Grasp, f64)>, second: Option<(Grasp, f64)>) -> Option<Grasp> {
    match (first, second) {
        (Some((a, first)), Some((b, second))) => Some(if second >= first { b } else { a }),
        (a, b) => a.or(b).map(|(grasp, _)| grasp),
    }
}

fn evaluated(problem: &Problem, grasp: &[u32]) -> PlannedGrasp {
    PlannedGrasp {
        contacts: grasp.iter().map(|&i| *problem.candidate(i)).collect(),
        margin: Evaluator::new().margin(&problem.wrenches(grasp)),
    }
}

fn nearest(problem: &Problem, seed: u64) -> Option<PlannedGrasp> {
    let (grasp, _) = nearest_start(problem, seed)?;
    Some(evaluated(problem, &grasp))
}
