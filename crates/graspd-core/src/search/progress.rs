//! Where a search stands, how much it may still do, and why it ended.

use super::problem::SearchProblem;
use crate::contact::Contact;
use crate::interrupt::Interrupted;

/// What a run is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Phase {
    /// Reading and preparing the mesh, before the plan begins.
    Preparing,
    /// Looking for the first force-closure grasp (Roa & Suárez, Algorithm 1).
    Initial,
    /// Improving it.
    Search,
    /// Running the analyses of the best grasp that the request asks for.
    Analysis,
}

/// Where a search stands.
#[derive(Debug, Clone, Copy)]
pub struct SearchProgress<'a> {
    pub phase: Phase,
    /// Generations completed, the initial population not counted.
    pub generation: usize,
    /// Quality evaluations so far.
    pub evaluations: u64,
    /// Best quality ε so far.
    pub best: Option<f64>,
    /// The grasp that has it; `None` outside the search.
    pub grasp: Option<BestGrasp<'a>>,
    /// `true` once for each entry of the history, at the moment it is made.
    pub generation_ended: bool,
}

/// The best grasp at one moment of a search.
#[derive(Debug, Clone, Copy)]
pub struct BestGrasp<'a> {
    pub(super) problem: &'a SearchProblem,
    pub(super) grasp: &'a [u32],
}

impl BestGrasp<'_> {
    /// Returns its contacts, the fixed ones first.
    pub fn contacts(&self) -> Vec<Contact> {
        self.problem.grasp_contacts(self.grasp)
    }
}

/// Why a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", schema(as = StoppedBecause))]
pub enum StopReason {
    /// All generations were run.
    GenerationLimit,
    /// `local`: no contact on the weakest facet can be improved by itself.
    LocalOptimum,
    /// The allowed number of evaluations is used up.
    EvaluationLimit,
    /// The target quality is reached.
    TargetQuality,
    /// The time limit is reached.
    TimeLimit,
    /// The run was cancelled.
    Cancelled,
    /// It is proven that no force-closure grasp exists.
    Impossible,
    /// No grasp that the constraints allow was found.
    Infeasible,
}

impl From<Interrupted> for StopReason {
    fn from(why: Interrupted) -> Self {
        match why {
            Interrupted::Cancelled => Self::Cancelled,
            Interrupted::TimeLimit => Self::TimeLimit,
        }
    }
}

/// Evaluations of the quality that a run may make, and those that it has made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    limit: Option<u64>,
    spent: u64,
}

impl Budget {
    /// A budget of `limit` evaluations; `None` for any number.
    pub const fn new(limit: Option<u64>) -> Self {
        Self { limit, spent: 0 }
    }

    /// Returns the number of evaluations made.
    pub fn spent(&self) -> u64 {
        self.spent
    }

    /// Returns the number of evaluations that may still be made.
    pub fn left(&self) -> u64 {
        self.limit
            .map_or(u64::MAX, |limit| limit.saturating_sub(self.spent))
    }

    /// Returns [`Self::left`].
    ///
    /// # Errors
    /// When that is none.
    pub fn left_or_stop(&self) -> Result<u64, StopReason> {
        match self.left() {
            0 => Err(StopReason::EvaluationLimit),
            left => Ok(left),
        }
    }

    /// Counts evaluations that were made.
    pub fn spend(&mut self, evaluations: u64) {
        self.spent += evaluations;
    }
}

/// Called between blocks of work, many times a second, from the thread that started the search.
pub type Observer<'a> = &'a mut (dyn FnMut(&SearchProgress<'_>) + Send);
