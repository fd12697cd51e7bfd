//! What a client asks for.

use serde::{Deserialize, Serialize};

/// A planning request with every default filled in and the seed fixed: the effective settings
/// that are stored with the job, echoed to the client and enough to repeat the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanRequest {}
