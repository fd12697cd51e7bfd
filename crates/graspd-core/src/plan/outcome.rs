//! What a planning run found.

use crate::analysis::Analysis;
use crate::constraints::RuleReport;
use crate::evaluation::Evaluation;
use crate::mesh::Candidate;
use crate::quality::{ACCURACY, Degenerate, Evaluator, Margin};
use crate::search::{Generation, Impossible, SearchProblem, StopReason};
use crate::wrench::WrenchModel;

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
    /// The best grasp and others that differ from it and each other, the best first; empty when only the best was
    /// asked for.
    pub top: Vec<PlannedGrasp>,
    /// The full evaluation of the best grasp; `None` too when the run was cancelled and it would take long.
    pub evaluation: Option<Evaluation>,
    /// The analyses of the best grasp; `None` too when they were not finished.
    pub analysis: Option<Analysis>,
    pub history: Vec<Generation>,
    pub evaluations: u64,
    pub stop: StopReason,
    /// Whether it is proven that no exchange of one finger improves the best grasp: see
    /// [`Outcome::single_exchange_optimal`](crate::search::Outcome::single_exchange_optimal).
    pub single_exchange_optimal: bool,
    /// What the polish gained, where there was one.
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

impl Plan {
    /// A plan before anything is found.
    pub(super) fn empty(model: WrenchModel) -> Self {
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
            stop: StopReason::Impossible,
            single_exchange_optimal: false,
            polish: None,
            impossible: None,
            infeasible: None,
        }
    }
}

impl PlannedGrasp {
    /// Evaluates a grasp to the [`ACCURACY`] of results.
    pub(super) fn new(problem: &SearchProblem, grasp: &[u32]) -> Self {
        let contacts = problem.grasp_contacts(grasp);
        let margin = Evaluator::new().grasp_margin(problem.model(), &contacts, ACCURACY);
        Self {
            contacts: grasp.iter().map(|&i| *problem.candidate(i)).collect(),
            margin,
            force_closure: margin.is_ok_and(|margin| problem.passes_closure_floor(&margin)),
        }
    }

    /// Returns ε of a force-closure grasp.
    pub(super) fn quality(&self) -> Option<f64> {
        let margin = self.margin.as_ref().ok().filter(|_| self.force_closure);
        margin.map(|margin| margin.value)
    }
}
