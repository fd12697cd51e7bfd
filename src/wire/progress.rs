//! The progress of planning runs.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::JobState;
use graspd_core::contact::Contact;
use graspd_core::search::Phase;

/// The data of an event `progress` of a job.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct JobProgress {
    /// The revision of the job.
    pub revision: u64,
    pub state: JobState,
    /// The progress of the run; absent while the job is queued.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub progress: Option<Progress>,
}

/// The progress of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Progress {
    pub phase: Phase,
    /// Generations completed, in all trials together.
    pub generation: u64,
    /// Generations requested, in all trials together.
    pub generations: u64,
    /// Quality evaluations so far.
    pub evaluations: u64,
    /// Best quality ε so far; null until a force-closure grasp is known.
    pub best_quality: Option<f64>,
    /// The contacts of the best grasp while the job runs: the fixed ones first, the others in an order that
    /// may change. Once the job has ended, the result has the contacts.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best_contacts: Option<Vec<Contact>>,
    /// Seconds since the run started.
    pub elapsed_s: f64,
}
