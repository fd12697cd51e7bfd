//! One planning run: validated settings and a mesh in, the best grasp found and its proof out.

mod finalize;
mod outcome;
mod polish_best;
mod prepare;
mod run;
mod search_best;
mod settings;
#[cfg(test)]
mod tests;
mod wrenches;

use crate::interrupt::Interrupt;
use crate::mesh::Mesh;
pub use crate::mismatch::{FARTHEST_CENTER, Mismatch};
pub use crate::search::Method;
use crate::search::{Observer, Phase, StopReason};
pub use outcome::{Infeasible, Plan, PlannedGrasp, Polish};
use prepare::NoProblem;
use run::Run;
pub use settings::{CandidateSource, Settings};
pub use wrenches::{
    ContactFault, ContactFields, ContactKind, ContactSettings, TORQUE_SCALES, TORSION_SHARE,
    TORSIONS, WrenchSettings,
};

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
    let mut run = Run::new(mesh, settings, model, interrupt, observe);
    run.report(Phase::Initial);
    let (problem, analyst) = match prepare::prepare(&mut run, &model) {
        Ok(prepared) => prepared,
        Err(NoProblem::Mismatch(mismatch)) => return Err(mismatch),
        Err(NoProblem::Infeasible(why)) => {
            run.set_infeasible(why);
            return Ok(run.finish());
        }
        Err(NoProblem::Interrupted(why)) => {
            run.plan.stop = why.into();
            return Ok(run.finish());
        }
    };
    let others = search_best::search_best(&mut run, &problem);
    if settings.polish && run.plan.stop != StopReason::Cancelled {
        polish_best::polish_best(&mut run, &problem);
    }
    if settings.top > 1 {
        finalize::choose_diverse(&mut run, &problem, &others);
    }
    finalize::evaluate(&mut run, &problem);
    if run.plan.stop != StopReason::Cancelled {
        finalize::analyse(&mut run, &analyst);
    }
    Ok(run.finish())
}
