//! The outbox of webhooks, which every server empties.

use std::time::Duration;

use async_trait::async_trait;
use sqlx::Row;
use uuid::Uuid;

use super::Postgres;
use crate::store::microseconds;
use crate::store::rows::{self, CallbackRow};
use crate::store::{Attempt, Delivery, Owner, StoreError, Webhooks, damaged};
use crate::wire::{CallbackRecord, CallbackState, JobId};

#[async_trait]
impl Webhooks for Postgres {
    async fn claim_webhook(
        &self,
        busy: &[&str],
        lease: Duration,
    ) -> Result<Option<Delivery>, StoreError> {
        let token = Uuid::new_v4().to_string();
        let row = sqlx::query(
            "WITH due AS (SELECT job_id FROM webhooks WHERE state = 'pending' AND due_at <= now_us() \
               AND host <> ALL($3) AND (leased_until IS NULL OR leased_until <= now_us()) \
               ORDER BY due_at LIMIT 1 FOR UPDATE SKIP LOCKED) \
             UPDATE webhooks SET lease = $1, leased_until = now_us() + $2 \
             FROM due WHERE webhooks.job_id = due.job_id \
             RETURNING webhooks.job_id, url, host, attempts, \
             (SELECT owner FROM jobs WHERE id = webhooks.job_id) AS owner, \
             EXISTS (SELECT 1 FROM results WHERE results.job_id = webhooks.job_id) AS has_result",
        )
        .bind(token.as_str())
        .bind(microseconds(lease))
        .bind(busy)
        .fetch_optional(&self.writes)
        .await?;
        let Some(row) = row else {
            return Ok(None);
        };
        Ok(Some(Delivery {
            job: rows::job_id(row.try_get("job_id")?)?,
            owner: Owner::of_key(row.try_get("owner")?),
            url: row.try_get("url")?,
            host: row.try_get("host")?,
            attempts: u32::try_from(row.try_get::<i64, _>("attempts")?).map_err(damaged)?,
            has_result: row.try_get("has_result")?,
            lease: token,
        }))
    }

    async fn settle_webhook(
        &self,
        delivery: &Delivery,
        attempt: &Attempt,
    ) -> Result<bool, StoreError> {
        let (state, error, pause) = match attempt {
            Attempt::Delivered => (CallbackState::Delivered, None, None),
            Attempt::Failed(why, None) => {
                (CallbackState::Failed, Some(why.replace('\0', " ")), None)
            }
            Attempt::Failed(why, Some(pause)) => (
                CallbackState::Pending,
                Some(why.replace('\0', " ")),
                Some(microseconds(*pause)),
            ),
        };
        let done = sqlx::query(
            "UPDATE webhooks SET state = $3, attempts = attempts + 1, last_error = $4, \
             last_attempt_at = now_us(), due_at = now_us() + $5, lease = NULL, leased_until = NULL \
             WHERE job_id = $1 AND lease = $2",
        )
        .bind(delivery.job.to_string())
        .bind(delivery.lease.as_str())
        .bind(state.name())
        .bind(error)
        .bind(pause)
        .execute(&self.writes)
        .await?;
        Ok(done.rows_affected() > 0)
    }

    async fn callback(&self, job: JobId) -> Result<Option<CallbackRecord>, StoreError> {
        let row: Option<CallbackRow> = sqlx::query_as(
            "SELECT request::json ->> 'callback_url' AS callback_url, \
             coalesce(webhooks.state, 'pending') AS callback_state, \
             coalesce(attempts, 0) AS attempts, last_error, last_attempt_at, due_at \
             FROM jobs LEFT JOIN webhooks ON job_id = id \
             WHERE id = $1 AND request::json ->> 'callback_url' IS NOT NULL",
        )
        .bind(job.to_string())
        .fetch_optional(&self.reads)
        .await?;
        row.map(TryInto::try_into).transpose()
    }
}
