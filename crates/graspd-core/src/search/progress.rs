//! Where a search stands, and why it ended.

use super::problem::Problem;
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
pub struct Progress<'a> {
    pub phase: Phase,
    /// Generations completed, the initial population not counted.
    pub generation: usize,
    /// Quality evaluations so far.
    pub evaluations: u64,
    /// Best quality ε so far.
    pub best: Option<f64>,
    /// The grasp that has it; told between two steps of the search, not within one.
    pub grasp: Option<BestGrasp<'a>>,
    /// `true` once for each entry of the history, at the moment it is made.
    pub generation_ended: bool,
}

/// The best grasp at some moment of a search.
#[derive(Debug, Clone, Copy)]
pub struct BestGrasp<'a> {
    pub(super) problem: &'a Problem,
    pub(super) grasp: &'a [u32],
}

impl BestGrasp<'_> {
    /// Its contacts, fixed ones first.
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
pub enum Stop {
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

impl From<Interrupted> for Stop {
    fn from(why: Interrupted) -> Self {
        match why {
            Interrupted::Cancelled => Self::Cancelled,
            Interrupted::TimeLimit => Self::TimeLimit,
        }
    }
}

/// Called between chunks of work, many times a second, from the thread that started the search.
pub type Observer<'a> = &'a mut (dyn FnMut(&Progress<'_>) + Send);
