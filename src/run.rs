//! One planning run as the outside sees it: request in, result out, with clock and time limit.

use std::ops::ControlFlow;

use crate::core::mesh::Mesh;
use crate::wire::{PlanRequest, PlanResult, Problem, Progress};

/// Plans a grasp on `mesh` with exactly the settings of `request`, on the current rayon pool.
///
/// `observe` is called many times a second with the state of the search; when it breaks, the run
/// stops and the result holds what was found so far, marked `cancelled`.
/// Fails with a [`Problem`] only when mesh and request do not fit together, such as more
/// contacts than candidates.
pub fn plan(
    mesh: &Mesh,
    request: &PlanRequest,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<PlanResult, Problem> {
    let _ = (mesh, request, observe);
    Err(Problem::new(
        500,
        "not-built",
        "Not built",
        "the planner is not wired up yet",
    ))
}
