//! API keys.

use async_trait::async_trait;

use super::Postgres;
use super::jobs::cancel;
use crate::store::StoreError;
use crate::store::common::keys::{AccessEngine, KeyEngine};

/// Whether a key is good now.
macro_rules! is_good {
    () => {
        "revoked_at IS NULL AND (expires_at IS NULL OR expires_at > now_us())"
    };
}

#[async_trait]
impl KeyEngine for Postgres {
    async fn insert_key(
        &self,
        id: &str,
        hash: &[u8],
        name: &str,
        expires_at: Option<i64>,
    ) -> Result<i64, StoreError> {
        let statement = sqlx::query(
            "INSERT INTO keys (id, name, hash, created_at, expires_at) \
             VALUES ($1, $2, $3, now_us(), $4) RETURNING created_at",
        )
        .bind(id)
        .bind(name)
        .bind(hash)
        .bind(expires_at);
        let (created_at,) = self.writes.run(statement).await?.one()?;
        Ok(created_at)
    }

    async fn cancel_jobs_of(&self, owner: &str) -> Result<u64, StoreError> {
        let waiting = sqlx::query(concat!(cancel!(), "WHERE owner = $1 AND state = 'queued'"));
        let mut cancelled = self.writes.run(waiting.bind(owner)).await?.changed();
        let running = sqlx::query("SELECT id FROM jobs WHERE owner = $1 AND state = 'running'");
        let running: Vec<(String,)> = self.reads.run(running.bind(owner)).await?.all()?;
        // One by one: a renewal locks many of them, in an order of its own.
        for (job,) in running {
            let mark = sqlx::query(concat!(
                cancel!(),
                "WHERE id = $1 AND state IN ('queued', 'running')"
            ));
            cancelled += self.writes.run(mark.bind(job)).await?.changed();
        }
        Ok(cancelled)
    }

    async fn revoke_key(&self, id: &str) -> Result<u64, StoreError> {
        let statement = sqlx::query(
            "UPDATE keys SET revoked_at = coalesce(revoked_at, now_us()) WHERE id = $1",
        );
        Ok(self.writes.run(statement.bind(id)).await?.changed())
    }
}

#[async_trait]
impl AccessEngine for Postgres {
    async fn hash_of(&self, id: &str) -> Result<Option<Vec<u8>>, StoreError> {
        let statement = sqlx::query(concat!(
            "SELECT hash FROM keys WHERE id = $1 AND ",
            is_good!()
        ));
        let answer = self.reads.run(statement.bind(id)).await?;
        Ok(answer.first()?.map(|(hash,)| hash))
    }

    async fn has_any_key(&self) -> Result<bool, StoreError> {
        let statement = sqlx::query(concat!(
            "SELECT EXISTS (SELECT 1 FROM keys WHERE ",
            is_good!(),
            ")"
        ));
        let (any,) = self.reads.run(statement).await?.one()?;
        Ok(any)
    }
}
