//! How far a planning run has come.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::JobState;
use graspd_core::contact::Contact;
use graspd_core::search::Phase;

/// What an event `progress` of a job tells.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct JobProgress {
    /// The revision of the job that has changed to this.
    pub revision: u64,
    pub state: JobState,
    /// Where the run stands; absent while the job waits.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub progress: Option<Progress>,
}

/// Where a run stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Progress {
    pub phase: Phase,
    /// Generations completed, of all trials.
    pub generation: u64,
    /// Generations asked for, of all trials.
    pub generations: u64,
    /// Quality evaluations so far.
    pub evaluations: u64,
    /// Best quality ε so far; null until a force-closure grasp is known.
    pub best_quality: Option<f64>,
    /// The contacts of the grasp that has it, fixed ones first, the others in no order that would last, while
    /// the job runs; once it has ended, the result has the contacts.
    #[schema(nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best_contacts: Option<Vec<Contact>>,
    /// Seconds since the run started.
    pub elapsed_s: f64,
}
