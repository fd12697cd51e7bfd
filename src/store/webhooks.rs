//! The outbox of webhooks: the deliveries of jobs that have ended to their callback URLs.
//!
//! A trigger fills it in the statement that ends the job. A delivery is taken under a lease, and each attempt is
//! written down; a delivery whose holder died is due again when the lease is over.

use std::time::Duration;

use async_trait::async_trait;

use super::{Owner, StoreError};
use crate::wire::{CallbackRecord, JobId};

/// A delivery that is due and that one sender has taken.
#[derive(Debug)]
pub struct Delivery {
    pub job: JobId,
    /// The owner of the job.
    pub owner: Owner,
    pub url: String,
    /// Host and, where it has one, port of the URL.
    pub host: String,
    /// How many attempts were made before.
    pub attempts: u32,
    /// Whether the job has a result.
    pub has_result: bool,
    pub(super) lease: String,
}

/// The outcome of an attempt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Attempt {
    Delivered,
    /// The reason, and the pause before the next attempt; `None` gives up.
    Failed(String, Option<Duration>),
}

/// The outbox of a store.
#[async_trait]
pub trait Webhooks {
    /// Takes the delivery that has been due for longest to a host that is not among `busy`, for as long as `lease`.
    /// Two callers never get the same. Costs time proportional to the deliveries due before it.
    async fn claim_webhook(
        &self,
        busy: &[&str],
        lease: Duration,
    ) -> Result<Option<Delivery>, StoreError>;

    /// Writes down the outcome of an attempt. Returns whether the lease still held; if not, nothing has changed.
    async fn record_attempt(
        &self,
        delivery: &Delivery,
        attempt: &Attempt,
    ) -> Result<bool, StoreError>;

    /// Returns the state of the callback of a job; `None` when it has none.
    async fn callback(&self, job: JobId) -> Result<Option<CallbackRecord>, StoreError>;
}
