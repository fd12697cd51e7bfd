//! A request in, a result out: planning runs and evaluations of given grasps, with clock, time limit and
//! explanations in words.
//!
//! The planner itself is `graspd-core`. This module turns a validated request into its settings, watches the
//! time while it works, and writes its results with the numbers that they depend on and with sentences.
//!
//! | file | subject |
//! |---|---|
//! | `settings.rs`, `candidates.rs`, `constraints.rs` | from the request to the settings of the core |
//! | `surface.rs` | the part of the mesh that is grasped |
//! | `place.rs` | given contacts, put on the mesh |
//! | `watch.rs`, `trials.rs` | the clock beside a run; runs repeated with other seeds |
//! | `evaluate.rs`, `analyses.rs` | given grasps; the analyses of a grasp |
//! | `result.rs`, `explain.rs` | from a plan to its result; numbers in words |
//! | `report.rs`, `figures.rs` | the report of a mesh, as data and for people to read |

mod analyses;
mod candidates;
mod constraints;
mod evaluate;
mod explain;
mod figures;
mod place;
mod report;
mod result;
mod settings;
mod surface;
mod trials;
mod watch;

pub use evaluate::{EvaluationFault, evaluate};
pub use figures::figures;
pub use report::mesh_report;
pub use surface::refuse_several;

use self::watch::Watch;
use crate::wire::{FieldError, PlanRequest, PlanResult, Problem, Progress};
use graspd_core::Interrupt;
use graspd_core::mesh::Mesh;
use graspd_core::plan::{self, Mismatch};

/// Plans a grasp on `mesh` with exactly the settings of `request`, on the current rayon pool.
///
/// `observe` is called many times a second with the state of the search. When `interrupt` comes, the run
/// stops and the result holds what was found so far, marked `cancelled`. The time limit of the request
/// counts from the call, and again from the end of the search, for the analyses of the grasp. Several trials
/// run one after the other; the result is that of the best.
///
/// # Errors
/// When the settings are out of range, or mesh and request do not fit together, such as more contacts than
/// candidates.
pub fn plan(
    mesh: &Mesh,
    request: &PlanRequest,
    interrupt: Interrupt<'_>,
    observe: &mut (dyn FnMut(&Progress) + Send),
) -> Result<PlanResult, Problem> {
    let mesh = surface::chosen(mesh, &request.surface)?;
    let mut result = match request.trials {
        0 | 1 => plan_once(&mesh, request, interrupt, observe),
        _ => trials::plan(&mesh, request, interrupt, observe),
    }?;
    result.mesh_warnings = surface::doubts(mesh.report());
    Ok(result)
}

fn plan_once(
    mesh: &Mesh,
    request: &PlanRequest,
    interrupt: Interrupt<'_>,
    observe: &mut (dyn FnMut(&Progress) + Send),
) -> Result<PlanResult, Problem> {
    let watch = Watch::start(request, interrupt, observe);
    let mut settings = settings::settings(request);
    let (source, candidates_from) = candidates::source(mesh, &settings.wrench, request)?;
    settings.candidates = source;
    let mut fixed = Vec::new();
    if let Some(wanted) = &request.constraints {
        let model = settings.wrench.model(mesh)?;
        (settings.constraints, fixed) = constraints::constraints(mesh, &model, wanted)?;
    }
    let ask = || watch.interrupted();
    let mut report = |progress: &graspd_core::search::SearchProgress<'_>| watch.report(progress);
    let plan = plan::plan(mesh, &settings, Interrupt::new(&ask), &mut report)?;
    let (elapsed, ended) = watch.end();
    Ok(result::result(
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
