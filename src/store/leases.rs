//! Jobs as workers hold them: claim, renew, finish, give back, recover.
//!
//! Whoever claims a job gets a lease with a token of its own. Every later write names the token and the attempt. It
//! changes nothing once the job has another holder, has ended or was forgotten.

use std::time::Duration;

use async_trait::async_trait;
use serde_json::value::RawValue;

use super::{Owner, StoreError};
use crate::wire::{JobId, MeshId, Priority, Problem, Progress};

/// More revisions than clients can have seen of a run beyond the one that is stored: 20 a second for half a day.
pub(super) const UNSEEN_REVISIONS: u32 = 1 << 20;

/// The right to write about a job that runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lease {
    pub job: JobId,
    pub(super) attempt: u32,
    pub(super) token: String,
}

/// A job that has been taken off the queue.
#[derive(Debug)]
pub struct Claim {
    pub lease: Lease,
    pub owner: Owner,
    pub mesh_id: MeshId,
    /// The effective settings, as JSON.
    pub request: String,
    /// The revision of the record, as the claim left it.
    pub revision: u64,
}

/// What a lease is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeaseStatus {
    /// Go on.
    Held,
    /// Stop: the job has been cancelled.
    Cancelled,
    /// Stop: the job was forgotten or has another holder.
    Lost,
}

/// The renewal of a lease, with the progress of the run.
#[derive(Debug, Clone)]
pub struct Renewal {
    pub lease: Lease,
    /// The last revision that clients have seen.
    pub revision: u64,
    pub progress: Progress,
}

/// How a run ended.
#[derive(Debug, Clone)]
pub enum RunOutcome {
    /// The planner's result, as JSON. The job is `cancelled` if a client asked for that meanwhile, else
    /// `succeeded`.
    Result(Box<RawValue>),
    /// The job was cancelled before there was any result.
    Cancelled,
    Problem(Problem),
}

/// The jobs of a store that run, or wait.
#[async_trait]
pub trait Leases {
    /// Returns how long a lease lasts unless it is renewed; `None` where it lasts as long as the process, because
    /// no other process can have the store.
    fn lease_time(&self) -> Option<Duration>;

    /// Takes the next job off the queue: of class `first` or, where none of these waits, of the other. Two callers
    /// never get the same job.
    ///
    /// Owners take turns: of those who wait the one with the fewest running jobs, and among these the one
    /// whose last job began first; of the owner's jobs the one that waits longest. Costs time proportional
    /// to the number of owners who wait.
    async fn claim(&self, first: Priority) -> Result<Option<Claim>, StoreError>;

    /// Returns whether the holder of `lease` should go on.
    async fn lease_status(&self, lease: &Lease) -> Result<LeaseStatus, StoreError>;

    /// Lets leases last for [`Leases::lease_time`] from the moment this was called, and writes down the
    /// progress of their runs. Returns for each, in their order, whether its holder should go on.
    async fn renew(&self, runs: &[Renewal]) -> Result<Vec<LeaseStatus>, StoreError>;

    /// Ends a job. `revision` is the last that clients have seen. Returns whether the lease still held; if not,
    /// nothing has changed.
    async fn finish(
        &self,
        lease: &Lease,
        ending: &RunOutcome,
        progress: &Progress,
        revision: u64,
    ) -> Result<bool, StoreError>;

    /// Puts a job back at its place in the queue as if it had not been taken, or ends it if it was cancelled
    /// meanwhile. Returns whether the lease still held.
    async fn release(&self, lease: &Lease, revision: u64) -> Result<bool, StoreError>;

    /// Takes every running job from a holder that is dead: back to the queue for another attempt; failed with
    /// `exhausted` if that would be more than `max_attempts`; cancelled if a client asked for that. Returns
    /// these jobs.
    ///
    /// Where leases last as long as the process, every holder is dead: this is for the start only.
    ///
    /// Nobody knows the last revision that the dead holder showed to clients. The new one is certainly larger.
    async fn recover(
        &self,
        max_attempts: u32,
        exhausted: &Problem,
    ) -> Result<Vec<JobId>, StoreError>;
}
