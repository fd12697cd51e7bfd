//! The outbox of webhooks.

use std::time::Duration;

use async_trait::async_trait;
use sqlx::Row;
use uuid::Uuid;

use super::{Sqlite, now};
use crate::store::microseconds;
use crate::store::rows::{self, CallbackRow};
use crate::store::{Attempt, Delivery, Owner, StoreError, Webhooks, damaged};
use crate::wire::{CallbackRecord, CallbackState, JobId};

/// More than the longest pause between two attempts.
const LONGEST_PAUSE: Duration = Duration::from_secs(30 * 3600);

#[async_trait]
impl Webhooks for Sqlite {
    async fn claim_webhook(
        &self,
        busy: &[&str],
        lease: Duration,
    ) -> Result<Option<Delivery>, StoreError> {
        let token = Uuid::new_v4().to_string();
        let busy = serde_json::to_string(busy).map_err(damaged)?;
        let now = now();
        let statement = sqlx::query(
            "UPDATE webhooks SET lease = ?1, leased_until = ?2 WHERE job_id = \
             (SELECT job_id FROM webhooks WHERE state = 'pending' AND (due_at <= ?3 OR due_at > ?5) \
              AND host NOT IN (SELECT value FROM json_each(?4)) \
              AND (leased_until IS NULL OR leased_until <= ?3) ORDER BY due_at LIMIT 1) \
             RETURNING job_id, url, host, attempts, \
             (SELECT owner FROM jobs WHERE id = job_id) AS owner, \
             EXISTS (SELECT 1 FROM jobs WHERE id = job_id AND result IS NOT NULL) AS has_result",
        )
        .bind(token.as_str())
        .bind(now.saturating_add(microseconds(lease)))
        .bind(now)
        .bind(busy)
        // No pause is so long: the clock was ahead when this was written.
        .bind(now.saturating_add(microseconds(LONGEST_PAUSE)));
        let rows = self.write_returning(statement).await?;
        let Some(row) = rows.first() else {
            return Ok(None);
        };
        let job: &str = row.try_get("job_id")?;
        Ok(Some(Delivery {
            job: rows::job_id(job)?,
            owner: Owner::of_key(row.try_get("owner")?),
            url: row.try_get("url")?,
            host: row.try_get("host")?,
            attempts: row.try_get("attempts")?,
            has_result: row.try_get("has_result")?,
            lease: token,
        }))
    }

    async fn settle_webhook(
        &self,
        delivery: &Delivery,
        attempt: &Attempt,
    ) -> Result<bool, StoreError> {
        let now = now();
        let (state, error, due) = match attempt {
            Attempt::Delivered => (CallbackState::Delivered, None, None),
            Attempt::Failed(why, None) => (CallbackState::Failed, Some(why), None),
            Attempt::Failed(why, Some(pause)) => {
                let due = now.saturating_add(microseconds(*pause));
                (CallbackState::Pending, Some(why), Some(due))
            }
        };
        let done = sqlx::query(
            "UPDATE webhooks SET state = ?3, attempts = attempts + 1, last_error = ?4, \
             last_attempt_at = ?5, due_at = ?6, lease = NULL, leased_until = NULL \
             WHERE job_id = ?1 AND lease = ?2",
        )
        .bind(delivery.job.to_string())
        .bind(delivery.lease.as_str())
        .bind(state.name())
        .bind(error)
        .bind(now)
        .bind(due)
        .execute(&self.writer)
        .await?;
        Ok(done.rows_affected() > 0)
    }

    async fn callback(&self, job: JobId) -> Result<Option<CallbackRecord>, StoreError> {
        let row: Option<CallbackRow> = sqlx::query_as(
            "SELECT json_extract(request, '$.callback_url') AS callback_url, \
             coalesce(webhooks.state, 'pending') AS callback_state, \
             coalesce(attempts, 0) AS attempts, last_error, last_attempt_at, due_at \
             FROM jobs LEFT JOIN webhooks ON job_id = id \
             WHERE id = ?1 AND callback_url IS NOT NULL",
        )
        .bind(job.to_string())
        .fetch_optional(&self.readers)
        .await?;
        row.map(TryInto::try_into).transpose()
    }
}

impl Sqlite {
    /// Takes every delivery from a holder that died with its process.
    ///
    /// Only for the start: it ends the leases of live senders too.
    pub(super) async fn release_webhooks(&self) -> Result<(), StoreError> {
        let release = || async {
            sqlx::query(
                "UPDATE webhooks SET lease = NULL, leased_until = NULL \
                 WHERE state = 'pending' AND lease IS NOT NULL",
            )
            .execute(&self.writer)
            .await?;
            Ok(())
        };
        self.with_reserve(release).await
    }
}
