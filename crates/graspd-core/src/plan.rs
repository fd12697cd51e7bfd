//! One planning run: validated settings and a mesh in, the best grasp found and its proof out.

mod ending;
mod slide;
#[cfg(test)]
mod tests;
mod wrenches;

use nalgebra::Point3;

use super::analysis::{Analysis, AnalysisSettings, Analyst};
use super::constraints::{Constraints, Filtered, RuleReport, any_apart};
use super::evaluation::Evaluation;
use super::interrupt::{Interrupt, Interrupted};
use super::mesh::{Candidate, Mesh};
pub use super::mismatch::{FARTHEST_CENTER, Mismatch};
use super::quality::{ACCURACY, Degenerate, Evaluator, Margin};
use super::search::{
    Exhaustion, Generation, GeneticSettings, Grasp, Impossible, Initial, InitialMode, Observer,
    Outcome, Phase, Problem, Progress, Stop, closure_floor, exhaust, impossible, initial_grasp,
    local, memetic, modified_ga, nearest_start, random_search,
};
use super::top;
use super::wrench::WrenchModel;
pub use wrenches::{
    ContactFault, ContactFields, ContactKind, ContactSettings, TORQUE_SCALES, TORSION_SHARE,
    TORSIONS, WrenchSettings,
};

/// Which search improves the first grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub enum Method {
    /// [`memetic`]: exchange with cuts and restarts.
    Memetic,
    /// [`modified_ga`]: the paper's.
    ModifiedGa,
    /// [`local`]: Roa & Suárez 2009.
    Local,
    /// [`random_search`]: the best of random grasps, with no first grasp to start from.
    Random,
}

/// Which places on the surface are candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(tag = "kind", rename_all = "snake_case"))]
pub enum CandidateSource {
    /// [`Mesh::candidates`].
    Triangles,
    /// [`Mesh::uniform_candidates`], from the seed of the run.
    Uniform { count: usize },
}

/// What to plan. Every field is validated before it gets here.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Number of contacts of a grasp, 1 to [`super::contact::MAX_CONTACTS`]: the fixed ones, which are
    /// fewer, and those to plan.
    pub contacts: usize,
    pub wrench: WrenchSettings,
    pub candidates: CandidateSource,
    pub method: Method,
    pub constraints: Constraints,
    pub initial: InitialMode,
    pub genetic: GeneticSettings,
    /// Whether the contacts of the best grasp are to slide over the surface to where it is better still.
    pub polish: bool,
    /// How many grasps to tell that [differ](super::top), the best included; at least one.
    pub top: usize,
    /// What else to tell of the best grasp.
    pub analysis: AnalysisSettings,
    pub seed: u64,
}

/// A grasp with its evaluation: exact, or an interval of relative width [`ACCURACY`].
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedGrasp {
    /// The planned contacts; the fixed ones stand before them.
    pub contacts: Vec<Candidate>,
    /// Where the origin stands in the grasp's wrench space, or why it has none.
    pub margin: Result<Margin, Degenerate>,
    /// Whether the margin is above what rounding of the mesh can feign.
    pub force_closure: bool,
}

/// What a planning run found.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// How the wrenches were made: with the point torques are taken about and the number λ.
    pub model: WrenchModel,
    /// Number of candidates n that were searched: those that the constraints leave.
    pub candidates: usize,
    /// How many candidates each rule of the constraints removed.
    pub removals: Vec<RuleReport>,
    /// The first force-closure grasp, found by Algorithm 1.
    pub initial: Option<PlannedGrasp>,
    /// The best force-closure grasp, or, when none was found, the random grasp nearest to it.
    pub best: Option<PlannedGrasp>,
    /// The best grasp and others that differ from it and each other, the best first; empty where none but
    /// the best was asked for.
    pub top: Vec<PlannedGrasp>,
    /// What else is told of the best grasp; `None` too when the run was cancelled and that would take long.
    pub evaluation: Option<Evaluation>,
    /// What was asked to be told of it; `None` too when it was not finished.
    pub analysis: Option<Analysis>,
    pub history: Vec<Generation>,
    pub evaluations: u64,
    pub stop: Stop,
    /// Whether it is proven that no exchange of one finger improves the best grasp: see
    /// [`Outcome::single_exchange_optimal`].
    pub single_exchange_optimal: bool,
    /// What sliding the contacts brought, where they slid.
    pub polish: Option<Polish>,
    /// The proof that no force-closure grasp exists, when there is one.
    pub impossible: Option<Impossible>,
    /// Why no grasp could be tried, when the constraints are to blame.
    pub infeasible: Option<Infeasible>,
}

/// How the contacts of the best grasp slid over the surface to where it is better.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
pub struct Polish {
    /// ε with every contact at the centroid of its triangle.
    pub quality_before: f64,
    /// The increase of ε by the sliding; never negative.
    pub gain: f64,
    pub evaluations: u64,
}

/// Why the constraints leave no grasp to try.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Infeasible {
    /// Fewer candidates are left than there are contacts to plan.
    TooFewLeft { planned: usize },
    /// More than one contact is to be planned, and no two candidates are as far apart as they have to be.
    NoneApart,
    /// No grasp was found whose contacts keep their distances, though that does not prove that there
    /// is none.
    NoneFits { planned: usize },
}

/// Finds an initial force-closure grasp and improves it, on the current rayon pool. Every grasp in the
/// plan keeps the constraints.
///
/// `observe` is called with the state of the search, and `interrupt` is checked, many times a second. When the
/// time limit is reached the search ends and its best grasp is still polished, evaluated and analysed; the
/// analysis, which begins with the first progress in [`Phase::Analysis`], ends when the interrupt comes again.
/// A cancellation ends everything at once. The plan holds what was found so far.
///
/// The same mesh, settings and seed give the same plan on any number of threads, unless it is interrupted.
pub fn plan(
    mesh: &Mesh,
    settings: &Settings,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) -> Result<Plan, Mismatch> {
    let model = settings.wrench.model(mesh)?;
    let mut plan = Plan::empty(model);
    observe(&progress(&plan, Phase::Initial));
    let candidates = match settings.candidates {
        CandidateSource::Triangles => mesh.candidates_interruptible(interrupt),
        CandidateSource::Uniform { count } => {
            mesh.uniform_candidates(count, settings.seed, interrupt)
        }
    };
    let candidates = match candidates {
        Ok(candidates) => candidates,
        Err(why) => return Ok(plan.stopped(why)),
    };
    let constraints = &settings.constraints;
    let planned = settings.contacts.saturating_sub(constraints.fixed.len());
    if planned > candidates.len() {
        return Err(Mismatch::TooFewCandidates {
            contacts: planned,
            candidates: candidates.len(),
        });
    }
    // Of all candidates: what rounding of the mesh can feign does not shrink with a part of it.
    let floor = closure_floor(&model, candidates.iter().map(|c| c.position));
    let Filtered { kept, removals } = match constraints.filter(candidates, interrupt) {
        Ok(filtered) => filtered,
        Err(why) => return Ok(plan.stopped(why)),
    };
    (plan.candidates, plan.removals) = (kept.len(), removals);
    let analyst = Analyst::new(mesh, &model, floor, &settings.analysis)?;
    let Some(problem) = Problem::new(kept, model, planned) else {
        plan.stop = Stop::Infeasible;
        plan.infeasible = Some(Infeasible::TooFewLeft { planned });
        return Ok(plan);
    };
    if let Some(least) = constraints
        .spacing
        .min
        .filter(|min| planned > 1 && *min > 0.0)
    {
        let places: Vec<Point3<f64>> = problem.candidates().iter().map(|c| c.position).collect();
        match any_apart(&places, least, interrupt) {
            Ok(Some(false)) => {
                plan.stop = Stop::Infeasible;
                plan.infeasible = Some(Infeasible::NoneApart);
                return Ok(plan);
            }
            Ok(_) => {}
            Err(why) => return Ok(plan.stopped(why)),
        }
    }
    let problem = problem
        .beside(constraints.fixed.clone(), constraints.spacing)
        .with_closure_floor(floor);
    let others = search(&problem, settings, &mut plan, interrupt, &mut *observe);
    if settings.polish && plan.stop != Stop::Cancelled {
        slide::slide(
            &mut plan,
            mesh,
            &problem,
            settings,
            interrupt,
            &mut *observe,
        );
    }
    if settings.top > 1 {
        let least = top::DISTINCT * mesh.report().bounding_radius;
        ending::choose(&mut plan, &problem, &others, settings.top, least, interrupt);
    }
    ending::evaluate(&mut plan, &problem, interrupt, &mut *observe);
    if plan.stop != Stop::Cancelled {
        ending::analyse(&mut plan, &constraints.fixed, &analyst, interrupt, observe);
    }
    Ok(plan)
}

impl Plan {
    /// Before anything is found.
    fn empty(model: WrenchModel) -> Self {
        Self {
            model,
            candidates: 0,
            removals: Vec::new(),
            initial: None,
            best: None,
            top: Vec::new(),
            evaluation: None,
            analysis: None,
            history: Vec::new(),
            evaluations: 0,
            stop: Stop::Impossible,
            single_exchange_optimal: false,
            polish: None,
            impossible: None,
            infeasible: None,
        }
    }

    fn stopped(self, why: Interrupted) -> Self {
        Self {
            stop: why.into(),
            ..self
        }
    }
}

/// Searches the best grasp, and gives others that were found, with their ε, the best first.
fn search(
    problem: &Problem,
    settings: &Settings,
    plan: &mut Plan,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) -> Vec<(Grasp, f64)> {
    let Settings { seed, genetic, .. } = settings;
    let Some(first) = first_grasp(problem, settings, plan, interrupt, observe) else {
        return Vec::new();
    };
    plan.initial = first.as_ref().map(|(grasp, _)| evaluated(problem, grasp));
    if let (Some((_, quality)), Some(target)) = (&first, genetic.target_quality)
        && *quality >= target
    {
        plan.stop = Stop::TargetQuality;
        plan.best = plan.initial.clone();
        return Vec::new();
    }
    let evaluations = &mut plan.evaluations;
    let start = first.clone();
    let outcome = match (settings.method, start) {
        (Method::Memetic, start) => memetic(
            problem,
            genetic,
            *seed,
            start,
            evaluations,
            interrupt,
            observe,
        ),
        (Method::ModifiedGa, start) => {
            let start = start.map(|(grasp, _)| grasp);
            modified_ga(
                problem,
                genetic,
                *seed,
                start,
                evaluations,
                interrupt,
                observe,
            )
        }
        (Method::Local, Some(start)) => local(
            problem,
            genetic,
            *seed,
            start,
            evaluations,
            interrupt,
            observe,
        ),
        (Method::Local, None) => Outcome {
            best: None,
            history: Vec::new(),
            stop: Stop::LocalOptimum,
            single_exchange_optimal: false,
            others: Vec::new(),
        },
        (Method::Random, _) => {
            random_search(problem, genetic, *seed, evaluations, interrupt, observe)
        }
    };
    plan.history = outcome.history;
    plan.stop = outcome.stop;
    plan.single_exchange_optimal = outcome.single_exchange_optimal;
    let mut best = better(first, outcome.best);
    if best.is_none() && plan.stop == Stop::GenerationLimit {
        observe(&progress(plan, Phase::Search));
        let limit = genetic.evaluation_limit;
        match exhaust(problem, limit, &mut plan.evaluations, interrupt) {
            Ok(Some(Exhaustion { grasps, best: None })) => {
                plan.impossible = Some(Impossible::Exhausted { grasps });
                plan.stop = Stop::Impossible;
            }
            Ok(Some(found)) => best = found.best.map(|(grasp, _)| grasp),
            Ok(None) => {}
            Err(why) => plan.stop = why.into(),
        }
    }
    if best.is_none() && plan.stop == Stop::GenerationLimit && plan.evaluations == 0 {
        let planned = problem.contacts();
        plan.stop = Stop::Infeasible;
        plan.infeasible = Some(Infeasible::NoneFits { planned });
    }
    plan.best = match best {
        Some(grasp) => Some(evaluated(problem, &grasp)),
        None => nearest(problem, plan, *seed, interrupt, observe),
    };
    outcome.others
}

/// The grasp of Algorithm 1, where the method starts from one and it was found. `None` when the search is over,
/// with the reason in the plan.
fn first_grasp(
    problem: &Problem,
    settings: &Settings,
    plan: &mut Plan,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) -> Option<Option<(Grasp, f64)>> {
    let initial = if settings.method == Method::Random {
        match impossible(problem, interrupt) {
            Ok(Some(proof)) => Initial::Impossible(proof),
            Ok(None) => Initial::NotFound,
            Err(why) => Initial::Stopped(why.into()),
        }
    } else {
        initial_grasp(
            problem,
            settings.initial,
            settings.seed,
            settings.genetic.evaluation_limit,
            &mut plan.evaluations,
            interrupt,
            &mut *observe,
        )
    };
    match initial {
        Initial::Found { grasp, quality } => Some(Some((grasp, quality))),
        Initial::NotFound => Some(None),
        Initial::NoneFits => {
            let planned = problem.contacts();
            plan.stop = Stop::Infeasible;
            plan.infeasible = Some(Infeasible::NoneFits { planned });
            None
        }
        Initial::Impossible(proof) => {
            plan.impossible = Some(proof);
            plan.best = nearest(problem, plan, settings.seed, interrupt, observe);
            None
        }
        Initial::Stopped(stop) => {
            plan.stop = stop;
            None
        }
    }
}

fn better(first: Option<(Grasp, f64)>, second: Option<(Grasp, f64)>) -> Option<Grasp> {
    match (first, second) {
        (Some((a, first)), Some((b, second))) => Some(if second >= first { b } else { a }),
        (a, b) => a.or(b).map(|(grasp, _)| grasp),
    }
}

fn evaluated(problem: &Problem, grasp: &[u32]) -> PlannedGrasp {
    let contacts = problem.grasp_contacts(grasp);
    let margin = Evaluator::new().grasp_margin(problem.model(), &contacts, ACCURACY);
    PlannedGrasp {
        contacts: grasp.iter().map(|&i| *problem.candidate(i)).collect(),
        margin,
        force_closure: margin.is_ok_and(|margin| problem.closes(&margin)),
    }
}

/// What to show without force closure; nothing when the run is to stop at once.
fn nearest(
    problem: &Problem,
    plan: &Plan,
    seed: u64,
    interrupt: Interrupt<'_>,
    observe: Observer<'_>,
) -> Option<PlannedGrasp> {
    observe(&progress(plan, Phase::Search));
    let grasp = nearest_start(problem, seed, interrupt)?;
    Some(evaluated(problem, &grasp))
}

/// Where a run stands outside its search.
fn progress(plan: &Plan, phase: Phase) -> Progress<'static> {
    let best = plan.best.as_ref().filter(|best| best.force_closure);
    Progress {
        phase,
        generation: plan.history.len().saturating_sub(1),
        evaluations: plan.evaluations,
        best: best.and_then(|best| Some(best.margin.ok()?.value)),
        grasp: None,
        generation_ended: false,
    }
}
