//! The outbox of webhooks, which every server empties.

use async_trait::async_trait;

use super::Postgres;
use crate::store::common::webhooks::{DeliveryRow, WebhookEngine};
use crate::store::{Delivery, StoreError};
use crate::wire::CallbackState;

#[async_trait]
impl WebhookEngine for Postgres {
    const CALLBACK: &'static str = "SELECT request::json ->> 'callback_url' AS callback_url, \
        coalesce(webhooks.state, 'pending') AS callback_state, \
        coalesce(attempts, 0) AS attempts, last_error, last_attempt_at, due_at \
        FROM jobs LEFT JOIN webhooks ON job_id = id \
        WHERE id = $1 AND request::json ->> 'callback_url' IS NOT NULL";

    async fn take_due(
        &self,
        busy: &[&str],
        token: &str,
        lease: i64,
    ) -> Result<Option<DeliveryRow>, StoreError> {
        let statement = sqlx::query(
            "WITH due AS (SELECT job_id FROM webhooks WHERE state = 'pending' AND due_at <= now_us() \
               AND host <> ALL($3) AND (leased_until IS NULL OR leased_until <= now_us()) \
               ORDER BY due_at LIMIT 1 FOR UPDATE SKIP LOCKED) \
             UPDATE webhooks SET lease = $1, leased_until = now_us() + $2 \
             FROM due WHERE webhooks.job_id = due.job_id \
             RETURNING webhooks.job_id, url, host, attempts, \
             (SELECT owner FROM jobs WHERE id = webhooks.job_id) AS owner, \
             EXISTS (SELECT 1 FROM results WHERE results.job_id = webhooks.job_id) AS has_result",
        );
        let statement = statement.bind(token).bind(lease).bind(busy);
        self.writes.run(statement).await?.first()
    }

    async fn write_attempt(
        &self,
        delivery: &Delivery,
        state: CallbackState,
        error: Option<&str>,
        pause: Option<i64>,
    ) -> Result<u64, StoreError> {
        let statement = sqlx::query(
            "UPDATE webhooks SET state = $3, attempts = attempts + 1, last_error = $4, \
             last_attempt_at = now_us(), due_at = now_us() + $5, lease = NULL, leased_until = NULL \
             WHERE job_id = $1 AND lease = $2",
        )
        .bind(delivery.job.to_string())
        .bind(delivery.lease.as_str())
        .bind(state.name())
        .bind(error.map(|error| error.replace('\0', " ")))
        .bind(pause);
        Ok(self.writes.run(statement).await?.changed())
    }
}
