//! What a planning run found.

use serde::{Deserialize, Serialize};

/// The outcome of a run, with every number that the quality depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct PlanResult {}
