//! The outbox of webhooks.

use std::time::Duration;

use async_trait::async_trait;

use super::{Sqlite, now};
use crate::store::common::webhooks::{DeliveryRow, WebhookEngine};
use crate::store::microseconds;
use crate::store::{Delivery, StoreError, damaged};
use crate::wire::CallbackState;

/// More than the longest pause between two attempts.
const LONGEST_PAUSE: Duration = Duration::from_secs(30 * 3600);

#[async_trait]
impl WebhookEngine for Sqlite {
    const CALLBACK: &'static str = "SELECT json_extract(request, '$.callback_url') AS callback_url, \
        coalesce(webhooks.state, 'pending') AS callback_state, \
        coalesce(attempts, 0) AS attempts, last_error, last_attempt_at, due_at \
        FROM jobs LEFT JOIN webhooks ON job_id = id \
        WHERE id = $1 AND callback_url IS NOT NULL";

    async fn take_due(
        &self,
        busy: &[&str],
        token: &str,
        lease: i64,
    ) -> Result<Option<DeliveryRow>, StoreError> {
        let now = now();
        let statement = sqlx::query(
            "UPDATE webhooks SET lease = $1, leased_until = $2 WHERE job_id = \
             (SELECT job_id FROM webhooks WHERE state = 'pending' AND (due_at <= $3 OR due_at > $5) \
              AND host NOT IN (SELECT value FROM json_each($4)) \
              AND (leased_until IS NULL OR leased_until <= $3) ORDER BY due_at LIMIT 1) \
             RETURNING job_id, url, host, attempts, \
             (SELECT owner FROM jobs WHERE id = job_id) AS owner, \
             EXISTS (SELECT 1 FROM jobs WHERE id = job_id AND result IS NOT NULL) AS has_result",
        )
        .bind(token)
        .bind(now.saturating_add(lease))
        .bind(now)
        .bind(serde_json::to_string(busy).map_err(damaged)?)
        // No pause is so long: the clock was ahead when this was written.
        .bind(now.saturating_add(microseconds(LONGEST_PAUSE)));
        self.writer.run(statement).await?.first()
    }

    async fn write_attempt(
        &self,
        delivery: &Delivery,
        state: CallbackState,
        error: Option<&str>,
        pause: Option<i64>,
    ) -> Result<u64, StoreError> {
        let now = now();
        let statement = sqlx::query(
            "UPDATE webhooks SET state = $3, attempts = attempts + 1, last_error = $4, \
             last_attempt_at = $5, due_at = $6, lease = NULL, leased_until = NULL \
             WHERE job_id = $1 AND lease = $2",
        )
        .bind(delivery.job.to_string())
        .bind(delivery.lease.as_str())
        .bind(state.name())
        .bind(error)
        .bind(now)
        .bind(pause.map(|pause| now.saturating_add(pause)));
        Ok(self.writer.run(statement).await?.changed())
    }
}

impl Sqlite {
    /// Takes every delivery from a holder that died with its process.
    ///
    /// Only for the start: it ends the leases of live senders too.
    pub(super) async fn release_webhooks(&self) -> Result<(), StoreError> {
        let release = || async {
            let statement = sqlx::query(
                "UPDATE webhooks SET lease = NULL, leased_until = NULL \
                 WHERE state = 'pending' AND lease IS NOT NULL",
            );
            self.writer.run(statement).await?;
            Ok(())
        };
        self.with_reserve(release).await
    }
}
