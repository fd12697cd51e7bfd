//! The settings of a planning run.

use super::wrenches::WrenchSettings;
use crate::analysis::AnalysisSettings;
use crate::constraints::Constraints;
use crate::search::{InitialMode, Method, SearchSettings};

/// Which places on the surface are candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(tag = "kind", rename_all = "snake_case"))]
pub enum CandidateSource {
    /// [`Mesh::candidates`](crate::mesh::Mesh::candidates).
    Triangles,
    /// [`Mesh::uniform_candidates`](crate::mesh::Mesh::uniform_candidates), from the seed of the run.
    Uniform { count: usize },
}

/// What to plan. Every field is validated before it gets here.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Number of contacts of a grasp, 1 to [`MAX_CONTACTS`](crate::contact::MAX_CONTACTS): the fixed ones, which are
    /// fewer, and those to plan.
    pub contacts: usize,
    pub wrench: WrenchSettings,
    pub candidates: CandidateSource,
    pub method: Method,
    pub constraints: Constraints,
    pub initial: InitialMode,
    pub search: SearchSettings,
    /// Most evaluations of the quality, those for the initial grasp and the polish included.
    pub evaluation_limit: Option<u64>,
    /// Whether the contacts of the best grasp slide over the surface to where it is better still.
    pub polish: bool,
    /// How many grasps that [differ](crate::diverse) to return, the best included; at least one.
    pub top: usize,
    /// Which analyses of the best grasp to make.
    pub analysis: AnalysisSettings,
    pub seed: u64,
}
