//! From a mesh and settings to the problem that is searched.

use nalgebra::Point3;

use super::outcome::Infeasible;
use super::run::Run;
use super::settings::CandidateSource;
use crate::analysis::Analyst;
use crate::constraints::{Filtered, any_apart};
use crate::interrupt::Interrupted;
use crate::mismatch::Mismatch;
use crate::search::{SearchProblem, closure_floor};
use crate::wrench::WrenchModel;

/// Why there is no problem to search.
pub(super) enum NoProblem {
    Mismatch(Mismatch),
    Infeasible(Infeasible),
    Interrupted(Interrupted),
}

impl From<Mismatch> for NoProblem {
    fn from(why: Mismatch) -> Self {
        Self::Mismatch(why)
    }
}

impl From<Interrupted> for NoProblem {
    fn from(why: Interrupted) -> Self {
        Self::Interrupted(why)
    }
}

/// Chooses the candidates, applies the constraints, and checks the settings of the analyses.
pub(super) fn prepare<'a>(
    run: &mut Run<'a>,
    model: &'a WrenchModel,
) -> Result<(SearchProblem, Analyst<'a>), NoProblem> {
    let (mesh, settings, interrupt) = (run.mesh, run.settings, run.interrupt);
    let constraints = &settings.constraints;
    let candidates = match settings.candidates {
        CandidateSource::Triangles => mesh.candidates_interruptible(interrupt)?,
        CandidateSource::Uniform { count } => {
            mesh.uniform_candidates(count, settings.seed, interrupt)?
        }
    };
    let planned = settings.contacts.saturating_sub(constraints.fixed.len());
    if planned > candidates.len() {
        return Err(NoProblem::Mismatch(Mismatch::TooFewCandidates {
            contacts: planned,
            candidates: candidates.len(),
        }));
    }
    // Of all candidates: what rounding of the mesh can feign does not shrink with a part of it.
    let floor = closure_floor(model, candidates.iter().map(|c| c.position));
    let Filtered { kept, removals } = constraints.filter(candidates, interrupt)?;
    (run.plan.candidates, run.plan.removals) = (kept.len(), removals);
    let analyst = Analyst::new(mesh, model, floor, &settings.analysis)?;
    let problem = SearchProblem::new(kept, *model, planned);
    let problem = problem.ok_or(NoProblem::Infeasible(Infeasible::TooFewLeft { planned }))?;
    let least = constraints.spacing.min.filter(|least| *least > 0.0);
    if let Some(least) = least.filter(|_| planned > 1) {
        let places: Vec<Point3<f64>> = problem.candidates().iter().map(|c| c.position).collect();
        if any_apart(&places, least, interrupt)? == Some(false) {
            return Err(NoProblem::Infeasible(Infeasible::NoneApart));
        }
    }
    let problem = problem
        .with_fixed(constraints.fixed.clone(), constraints.spacing)
        .with_closure_floor(floor);
    Ok((problem, analyst))
}
