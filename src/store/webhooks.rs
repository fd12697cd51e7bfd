//! The outbox of webhooks: who is to be told that a job has ended.
//!
//! A trigger fills it in the statement that ends the job. A delivery is taken under a lease and
//! written down when it was tried; one whose holder died is due again when the lease is over.

use std::time::Duration;

use async_trait::async_trait;

use super::{Owner, StoreError};
use crate::wire::{CallbackRecord, JobId};

/// A message that is due, in the hands of one sender.
#[derive(Debug)]
pub struct Delivery {
    pub job: JobId,
    /// Whose job it is.
    pub owner: Owner,
    pub url: String,
    /// Host and, where it has one, port of the URL.
    pub host: String,
    /// How often it was tried before.
    pub attempts: u32,
    /// Whether the job has a result.
    pub has_result: bool,
    pub(super) lease: String,
}

/// What became of an attempt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Attempt {
    Delivered,
    /// Why not, and the pause before the next attempt; `None` gives up.
    Failed(String, Option<Duration>),
}

/// The outbox of a store.
#[async_trait]
pub trait Webhooks {
    /// Takes the delivery that has been due for longest to a host that is not among `busy`, for
    /// as long as `lease`. Two callers never get the same. Costs time proportional to the
    /// deliveries due before it.
    async fn claim_webhook(
        &self,
        busy: &[&str],
        lease: Duration,
    ) -> Result<Option<Delivery>, StoreError>;

    /// Writes down what became of an attempt. Says whether the delivery was still in these hands;
    /// if not, nothing has changed.
    async fn settle_webhook(
        &self,
        delivery: &Delivery,
        attempt: &Attempt,
    ) -> Result<bool, StoreError>;

    /// What is known of the callback of a job; `None` when it has none.
    async fn callback(&self, job: JobId) -> Result<Option<CallbackRecord>, StoreError>;
}
