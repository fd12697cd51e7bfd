//! One planning run: validated settings and a mesh in, the best grasp found and its proof out.
//!
//! ```text
//! prepare      candidates of the surface, less those that the constraints forbid
//! search       Algorithm 1: a first force-closure grasp, or a proof that none exists
//!              the chosen method improves it; a small problem without a grasp is searched exhaustively
//! polish       the contacts of the best grasp slide over the surface
//! diverse      other good grasps that differ from the best and each other, where more than one is asked for
//! evaluate     all measures of the best grasp
//! analyse      robustness, regions and tasks of the best grasp, as far as asked for
//! ```
//!
//! Each stage takes what the one before has left in the [`Plan`], which holds a valid result after every stage: an
//! interruption keeps what was found. All evaluations come from one budget. A time limit ends the search, and the
//! stages after it, which are short or have the limit anew, still run; a cancellation skips them, except for an
//! evaluation of a few milliseconds.
//!
//! It ends because every stage does. Nearly all of the time goes into the search, whose methods state their cost.

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
///
/// # Errors
/// When the settings do not suit the mesh.
///
/// # Examples
/// A grasp of a block by four fingers with friction:
///
/// ```
/// use std::sync::atomic::{AtomicBool, Ordering};
///
/// use graspd_core::analysis::AnalysisSettings;
/// use graspd_core::constraints::{Constraints, Region};
/// use graspd_core::contact::{Cone, ConeEdges, ContactModel, Friction};
/// use graspd_core::mesh::{Mesh, solids};
/// use graspd_core::plan::{CandidateSource, ContactSettings, Method, Settings, WrenchSettings, plan};
/// use graspd_core::search::{InitialMode, SearchSettings, StopReason};
/// use graspd_core::wrench::{EdgeNorm, TorqueScale, WrenchSpace};
/// use graspd_core::{Interrupt, Interrupted};
///
/// let mesh = Mesh::prepare(solids::cuboid([0.0; 3], [0.2, 0.1, 0.05])).unwrap();
/// let contact = ContactModel::Hard {
///     friction: Friction::new(0.5).unwrap(),
///     cone: Cone::Pyramid(ConeEdges::new(8).unwrap()),
/// };
/// let settings = Settings {
///     contacts: 4,
///     wrench: WrenchSettings {
///         contact: ContactSettings::Known(contact),
///         edge_norm: EdgeNorm::UnitEdge,
///         space: WrenchSpace::L1,
///         torque_scale: TorqueScale::MaxRadius,
///         center_of_mass: None,
///     },
///     candidates: CandidateSource::Uniform { count: 500 },
///     method: Method::Memetic,
///     constraints: Constraints::default(),
///     initial: InitialMode::Weak,
///     search: SearchSettings {
///         population: 4,
///         generations: 2,
///         crossover_probability: 0.7,
///         mutation_probability: 0.2,
///         elitism: 1,
///         target_quality: None,
///     },
///     evaluation_limit: Some(20_000),
///     polish: true,
///     top: 1,
///     analysis: AnalysisSettings::default(),
///     seed: 1,
/// };
/// let found = plan(&mesh, &settings, Interrupt::never(), &mut |_| {}).unwrap();
/// let best = found.best.unwrap();
/// assert!(best.force_closure);
/// let free = best.margin.unwrap().value;
///
/// // The same with fingers in one half of the block only: never better.
/// let half = Region::Box {
///     min: [0.0, 0.0, 0.0].into(),
///     max: [0.1, 0.1, 0.05].into(),
/// };
/// let constrained = Settings {
///     constraints: Constraints {
///         include: vec![half.clone()],
///         ..Constraints::default()
///     },
///     ..settings.clone()
/// };
/// let found = plan(&mesh, &constrained, Interrupt::never(), &mut |_| {}).unwrap();
/// let best = found.best.unwrap();
/// assert!(best.contacts.iter().all(|contact| half.contains(contact)));
/// assert!(best.margin.unwrap().value < free);
///
/// // Cancelled as soon as there is a grasp: the plan holds it.
/// let cancelled = AtomicBool::new(false);
/// let ask = || cancelled.load(Ordering::Relaxed).then_some(Interrupted::Cancelled);
/// let found = plan(&mesh, &settings, Interrupt::new(&ask), &mut |progress| {
///     cancelled.store(progress.best.is_some(), Ordering::Relaxed);
/// });
/// let found = found.unwrap();
/// assert_eq!(found.stop, StopReason::Cancelled);
/// assert!(found.best.is_some_and(|best| best.force_closure));
/// ```
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
