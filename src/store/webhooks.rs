//! The outbox of webhooks: who is to be told that a job has ended.
//!
//! A trigger fills it in the statement that ends the job. A delivery is taken under a lease and
//! written down when it was tried; one whose holder died is due again when the lease is over.

use std::time::Duration;

use sqlx::Row;
use uuid::Uuid;

use super::{Owner, Store, StoreError, damaged, now, timestamp};
use crate::wire::{CallbackRecord, CallbackState, JobId};

/// More than the longest pause between two attempts.
const LONGEST_PAUSE: Duration = Duration::from_secs(30 * 3600);

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
    lease: String,
}

/// What became of an attempt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Attempt {
    Delivered,
    /// Why not, and the pause before the next attempt; `None` gives up.
    Failed(String, Option<Duration>),
}

impl Store {
    /// Takes the delivery that has been due for longest to a host that is not among `busy`, for
    /// as long as `lease`. Two callers never get the same. Costs time proportional to the
    /// deliveries due before it.
    pub async fn claim_webhook(
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
            job: JobId::parse(job).ok_or_else(|| damaged("job id"))?,
            owner: Owner::of_key(row.try_get("owner")?),
            url: row.try_get("url")?,
            host: row.try_get("host")?,
            attempts: row.try_get("attempts")?,
            has_result: row.try_get("has_result")?,
            lease: token,
        }))
    }

    /// Writes down what became of an attempt. Says whether the delivery was still in these hands;
    /// if not, nothing has changed.
    pub async fn settle_webhook(
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

    /// Takes every delivery from a holder that died with its process.
    ///
    /// Only for the start: it ends the leases of live senders too.
    pub async fn release_webhooks(&self) -> Result<(), StoreError> {
        sqlx::query(
            "UPDATE webhooks SET lease = NULL, leased_until = NULL \
             WHERE state = 'pending' AND lease IS NOT NULL",
        )
        .execute(&self.writer)
        .await?;
        Ok(())
    }

    /// What is known of the callback of a job; `None` when it has none.
    pub async fn callback(&self, job: JobId) -> Result<Option<CallbackRecord>, StoreError> {
        let row = sqlx::query(
            "SELECT json_extract(request, '$.callback_url') AS callback_url, \
             coalesce(webhooks.state, 'pending') AS callback_state, \
             coalesce(attempts, 0) AS attempts, last_error, last_attempt_at, due_at \
             FROM jobs LEFT JOIN webhooks ON job_id = id \
             WHERE id = ?1 AND callback_url IS NOT NULL",
        )
        .bind(job.to_string())
        .fetch_optional(&self.readers)
        .await?;
        let Some(row) = row else {
            return Ok(None);
        };
        let state: &str = row.try_get("callback_state")?;
        let time = |column| -> Result<_, StoreError> {
            let time: Option<i64> = row.try_get(column)?;
            time.map(timestamp).transpose()
        };
        Ok(Some(CallbackRecord {
            url: row.try_get("callback_url")?,
            state: CallbackState::named(state).ok_or_else(|| damaged("callback state"))?,
            attempts: row.try_get("attempts")?,
            last_error: row.try_get("last_error")?,
            last_attempt_at: time("last_attempt_at")?,
            next_attempt_at: time("due_at")?,
        }))
    }
}

fn microseconds(duration: Duration) -> i64 {
    i64::try_from(duration.as_micros()).unwrap_or(i64::MAX)
}
