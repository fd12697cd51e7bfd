//! What is kept no longer: jobs that ended long ago, meshes that nobody uses, keys of old submissions.

use std::time::Duration;

use async_trait::async_trait;

use super::{Owner, StoreError};
use crate::wire::JobId;

/// The most rows that one statement removes, so that submissions never wait long for it.
pub(super) const BATCH: u32 = 200;

/// What a sweep removed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Expired {
    pub jobs: u64,
    pub meshes: u64,
}

/// What a store forgets by itself.
#[async_trait]
pub trait Retention {
    /// Removes jobs that ended, batches of which no job is left, and meshes that no job names and nobody asked
    /// for, longer than `retention` ago; for as long again it is remembered which jobs and batches these were.
    /// Must be run to its end.
    async fn expire(&self, retention: Duration) -> Result<Expired, StoreError>;

    /// Forgets the keys of submissions of more than 24 hours ago.
    async fn forget_submissions(&self) -> Result<(), StoreError>;

    /// Returns whether a job was here and has expired.
    async fn has_expired(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError>;
}
