//! What outlives the process: meshes, jobs, keys, and who is to be told.
//!
//! [`Store`] is the one contract, by subject; [`sqlite`] keeps it in a folder that one process has for itself,
//! [`postgres`] in a database that many servers and workers share. What a call acknowledges is on stable
//! storage; every change is a single guarded statement or a transaction, never one that lasts as long as a job.

mod batches;
mod cursor;
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
mod rows;
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
pub use leases::{Claim, Ending, Hold, Lease, Leases, Standing};
pub use meshes::{Deletion, Kept, Meshes, NewMesh};
pub use notices::{Audience, Listener, Notice, Notices};
pub use owner::Owner;
pub use retention::{Expired, Retention};
pub use submissions::{Earlier, Submission, Submissions};
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

/// A store that is shared; clones are the same one.
pub type SharedStore = Arc<dyn Store>;

/// In the unit of all times in a store.
fn microseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_micros()).unwrap_or(i64::MAX)
}

fn timestamp(microseconds: i64) -> Result<Timestamp, StoreError> {
    Timestamp::from_microsecond(microseconds)
        .map_err(|error| StoreError::Damaged(error.to_string()))
}

fn damaged(error: impl std::fmt::Display) -> StoreError {
    StoreError::Damaged(error.to_string())
}
