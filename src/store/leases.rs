//! Jobs as workers hold them: claim, renew, finish, give back, recover.
//!
//! Whoever claims a job gets a lease with a token of its own. Every later write names it and
//! changes nothing once the job is in other hands, was ended or was forgotten.

use std::time::Duration;

use async_trait::async_trait;
use serde_json::value::RawValue;

use super::{Owner, StoreError};
use crate::wire::{JobId, MeshId, Priority, Problem, Progress};

/// More revisions than clients can have seen of a run beyond the one that is stored: 20 a second for half
/// a day.
pub(super) const UNSEEN_REVISIONS: u32 = 1 << 20;

/// The right to write about a running job.
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
    /// Of the record, as the claim left it.
    pub revision: u64,
}

/// What a lease is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// Go on.
    Held,
    /// Stop: the job has been cancelled.
    Cancelled,
    /// Stop: the job was forgotten or is in other hands.
    Lost,
}

/// Where a run stands, as its holder tells it when it renews the lease.
#[derive(Debug, Clone)]
pub struct Standing {
    pub lease: Lease,
    /// The last that clients have seen.
    pub revision: u64,
    pub progress: Progress,
}

/// How a run ended.
#[derive(Debug, Clone)]
pub enum Ending {
    /// The planner's result, as JSON. The job is `cancelled` if that was asked for meanwhile,
    /// else `succeeded`.
    Result(Box<RawValue>),
    /// The job was cancelled before there was any result.
    Nothing,
    Problem(Problem),
}

/// The jobs of a store that are held, or wait to be.
#[async_trait]
pub trait Leases {
    /// How long a lease lasts unless it is renewed; `None` where one lasts as long as the process, because no
    /// other process can have the store.
    fn lease_time(&self) -> Option<Duration>;

    /// Takes the next job off the queue: of class `first` or, where none of these waits, of the other. Two
    /// callers never get the same.
    ///
    /// Owners take turns: of those who wait the one with the fewest running jobs, and among these the one
    /// whose last job began first; of the owner's jobs the one that waits longest. Costs time proportional
    /// to the number of owners who wait.
    async fn claim(&self, first: Priority) -> Result<Option<Claim>, StoreError>;

    /// Whether the holder of `lease` should go on.
    async fn hold(&self, lease: &Lease) -> Result<Hold, StoreError>;

    /// Lets leases last for [`Leases::lease_time`] from the moment this was called, and writes down where their
    /// runs stand. Says of each, in their order, whether its holder should go on.
    async fn renew(&self, runs: &[Standing]) -> Result<Vec<Hold>, StoreError>;

    /// Ends a job. `revision` is the last that clients have seen. Says whether the lease still
    /// held; if not, nothing has changed.
    async fn finish(
        &self,
        lease: &Lease,
        ending: &Ending,
        progress: &Progress,
        revision: u64,
    ) -> Result<bool, StoreError>;

    /// Puts a job back at its place in the queue as if it had not been taken, or ends it if it
    /// was cancelled meanwhile. Says whether the lease still held.
    async fn release(&self, lease: &Lease, revision: u64) -> Result<bool, StoreError>;

    /// Takes every running job from a holder that is dead: back to the queue for another attempt; failed with
    /// `exhausted` if that would be more than `max_attempts`; cancelled if that was asked for. Says which.
    ///
    /// Where leases last as long as the process, every holder is: this is for the start only.
    ///
    /// Nobody knows how far the revision had come that the dead holder showed to clients; the new one is
    /// past it for sure.
    async fn recover(
        &self,
        max_attempts: u32,
        exhausted: &Problem,
    ) -> Result<Vec<JobId>, StoreError>;
}
