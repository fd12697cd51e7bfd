//! Everything that outlives the process: meshes, jobs, batches, keys, and deliveries of webhooks.
//!
//! [`Store`] is the one contract, by subject. Two engines keep it: [`sqlite`] in a folder that one process has for
//! itself, [`postgres`] in a database that many servers and workers share. What both do alike is in `common`; each
//! engine has the statements that only it understands, and says in its head who may write when and what survives.
//! The tests in `tests/` hold each promise of the contract against both.
//!
//! What a call acknowledges is on stable storage. Every change is a single guarded statement or a transaction, never
//! one that lasts as long as a job.

mod batches;
mod common;
mod error;
mod health;
mod jobs;
mod keys;
mod leases;
mod meshes;
mod notices;
mod owner;
pub mod postgres;
mod retention;
pub mod sqlite;
mod submissions;
#[cfg(test)]
pub(crate) mod tests;
mod uploads;
mod webhooks;

use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;

pub use batches::{BatchedJob, Batches, NewBatch};
pub use error::{OpenError, StoreError};
pub use health::Health;
pub use jobs::{JobFilter, Jobs, NewJob, Refusal, Unfinished};
pub use keys::{Access, KeyRecord, Keys, NewKey};
pub use leases::{Claim, Lease, LeaseStatus, Leases, Renewal, RunOutcome};
pub use meshes::{Deletion, MeshSummary, Meshes, NewMesh};
pub use notices::{Audience, Listener, Notice, Notices};
pub use owner::Owner;
pub use retention::{Expired, Retention};
pub use submissions::{EarlierSubmission, Submission, Submissions};
pub use uploads::{Received, Upload};
pub use webhooks::{Attempt, Delivery, Webhooks};

/// Most items of one page of a list.
pub const MAX_PAGE: u32 = 1000;

/// Everything that outlives the process.
pub trait Store:
    Jobs
    + Batches
    + Leases
    + Meshes
    + Submissions
    + Retention
    + Webhooks
    + Access
    + Health
    + Notices
    + Send
    + Sync
{
}

impl<T> Store for T where
    T: Jobs
        + Batches
        + Leases
        + Meshes
        + Submissions
        + Retention
        + Webhooks
        + Access
        + Health
        + Notices
        + Send
        + Sync
{
}

/// A store that several tasks share.
pub type SharedStore = Arc<dyn Store>;

/// A duration in microseconds, the unit of all times in a store.
fn microseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_micros()).unwrap_or(i64::MAX)
}

/// The moment that a store writes as this number.
fn timestamp(microseconds: i64) -> Result<Timestamp, StoreError> {
    Timestamp::from_microsecond(microseconds)
        .map_err(|error| StoreError::Damaged(error.to_string()))
}

/// The error for a record that cannot be read.
fn damaged(error: impl std::fmt::Display) -> StoreError {
    StoreError::Damaged(error.to_string())
}
