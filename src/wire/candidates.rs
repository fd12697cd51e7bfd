//! The places that are searched.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Which places on the surface are candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CandidateKind {
    /// The centroid of every triangle, as in the paper: as even as the triangles are.
    Triangles,
    /// Places spread evenly over the surface, whatever the triangles (Yuksel 2015), from the seed.
    Uniform,
}

/// Which candidates a run searched, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = CandidateSource)]
pub struct SearchedCandidates {
    pub kind: CandidateKind,
    /// How many there were before the constraints.
    pub count: u64,
    /// Why these, in words.
    pub because: String,
}
