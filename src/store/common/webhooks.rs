//! The outbox of webhooks.

use std::time::Duration;

use async_trait::async_trait;
use sqlx::FromRow;
use uuid::Uuid;

use super::rows::{self, CallbackRow};
use super::statement::Statement;
use super::{Engine, first};
use crate::store::{Attempt, Delivery, Owner, StoreError, Webhooks, microseconds};
use crate::wire::{CallbackRecord, CallbackState, JobId};

/// The operations on webhooks that each engine implements itself.
#[async_trait]
pub trait WebhookEngine: Engine {
    /// Returns the state of the callback of a job that has one.
    const CALLBACK: &'static str;

    /// Takes the delivery that has been due for longest, under a lease with this token and time in microseconds.
    async fn take_due(
        &self,
        busy: &[&str],
        token: &str,
        lease: i64,
    ) -> Result<Option<DeliveryRow>, StoreError>;

    /// Writes down an attempt; `pause` is the time to the next one in microseconds. Returns how many deliveries
    /// were still under this lease.
    async fn write_attempt(
        &self,
        delivery: &Delivery,
        state: CallbackState,
        error: Option<&str>,
        pause: Option<i64>,
    ) -> Result<u64, StoreError>;
}

/// A delivery that has been taken.
#[derive(FromRow)]
pub struct DeliveryRow {
    job_id: String,
    owner: String,
    url: String,
    host: String,
    attempts: i64,
    has_result: bool,
}

#[async_trait]
impl<E: WebhookEngine> Webhooks for E {
    async fn claim_webhook(
        &self,
        busy: &[&str],
        lease: Duration,
    ) -> Result<Option<Delivery>, StoreError> {
        let token = Uuid::new_v4().to_string();
        let Some(row) = self.take_due(busy, &token, microseconds(lease)).await? else {
            return Ok(None);
        };
        Ok(Some(Delivery {
            job: rows::job_id(&row.job_id)?,
            owner: Owner::of_key(&row.owner),
            url: row.url,
            host: row.host,
            attempts: rows::count(row.attempts)?,
            has_result: row.has_result,
            lease: token,
        }))
    }

    async fn record_attempt(
        &self,
        delivery: &Delivery,
        attempt: &Attempt,
    ) -> Result<bool, StoreError> {
        let (state, error, pause) = match attempt {
            Attempt::Delivered => (CallbackState::Delivered, None, None),
            Attempt::Failed(why, None) => (CallbackState::Failed, Some(why), None),
            Attempt::Failed(why, Some(pause)) => (
                CallbackState::Pending,
                Some(why),
                Some(microseconds(*pause)),
            ),
        };
        let error = error.map(String::as_str);
        let written = self.write_attempt(delivery, state, error, pause).await?;
        Ok(written > 0)
    }

    async fn callback(&self, job: JobId) -> Result<Option<CallbackRecord>, StoreError> {
        let statement = Statement::new(E::CALLBACK).bind(job.to_string());
        let row: Option<CallbackRow> = first(self, statement).await?;
        row.map(TryInto::try_into).transpose()
    }
}
