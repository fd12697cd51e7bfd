//! API keys.

use async_trait::async_trait;
use jiff::Timestamp;

use super::Postgres;
use super::jobs::cancel;
use crate::store::keys::{Fresh, Presented};
use crate::store::rows::KeyRow;
use crate::store::{Access, KeyRecord, Keys, NewKey, Owner, StoreError, timestamp};

/// Whether a key is good now.
macro_rules! good {
    () => {
        "revoked_at IS NULL AND (expires_at IS NULL OR expires_at > now_us())"
    };
}

#[async_trait]
impl Keys for Postgres {
    async fn create(
        &self,
        name: &str,
        expires_at: Option<Timestamp>,
    ) -> Result<NewKey, StoreError> {
        let key = Fresh::draw()?;
        let created_at: i64 = sqlx::query_scalar(
            "INSERT INTO keys (id, name, hash, created_at, expires_at) \
             VALUES ($1, $2, $3, now_us(), $4) RETURNING created_at",
        )
        .bind(&key.id)
        .bind(name)
        .bind(&key.hash()[..])
        .bind(expires_at.map(Timestamp::as_microsecond))
        .fetch_one(&self.writes)
        .await?;
        Ok(key.into_key(name, timestamp(created_at)?, expires_at))
    }

    async fn list(&self) -> Result<Vec<KeyRecord>, StoreError> {
        let rows: Vec<KeyRow> = sqlx::query_as(
            "SELECT id, name, created_at, expires_at, revoked_at FROM keys ORDER BY created_at, id",
        )
        .fetch_all(&self.reads)
        .await?;
        rows.into_iter().map(TryInto::try_into).collect()
    }

    async fn cancel_jobs(&self, id: &str) -> Result<u64, StoreError> {
        let waiting = sqlx::query(concat!(cancel!(), "WHERE owner = $1 AND state = 'queued'"))
            .bind(id)
            .execute(&self.writes)
            .await?;
        let running: Vec<String> =
            sqlx::query_scalar("SELECT id FROM jobs WHERE owner = $1 AND state = 'running'")
                .bind(id)
                .fetch_all(&self.reads)
                .await?;
        let mut cancelled = waiting.rows_affected();
        // One by one: a renewal locks many of them, in an order of its own.
        for job in running {
            let marked = sqlx::query(concat!(
                cancel!(),
                "WHERE id = $1 AND state IN ('queued', 'running')"
            ))
            .bind(job)
            .execute(&self.writes)
            .await?;
            cancelled += marked.rows_affected();
        }
        Ok(cancelled)
    }

    async fn revoke(&self, id: &str) -> Result<bool, StoreError> {
        let done = sqlx::query(
            "UPDATE keys SET revoked_at = coalesce(revoked_at, now_us()) WHERE id = $1",
        )
        .bind(id)
        .execute(&self.writes)
        .await?;
        Ok(done.rows_affected() > 0)
    }
}

#[async_trait]
impl Access for Postgres {
    async fn owner_of(&self, key: &str) -> Result<Option<Owner>, StoreError> {
        let Some(key) = Presented::parse(key) else {
            return Ok(None);
        };
        let kept: Option<Vec<u8>> =
            sqlx::query_scalar(concat!("SELECT hash FROM keys WHERE id = $1 AND ", good!()))
                .bind(key.id)
                .fetch_optional(&self.reads)
                .await?;
        let is_right = kept.is_some_and(|kept| key.is(&kept));
        Ok(is_right.then(|| Owner::of_key(key.id)))
    }

    async fn is_good(&self, owner: &Owner) -> Result<bool, StoreError> {
        if owner.is_anonymous() {
            return Ok(true);
        }
        Ok(sqlx::query_scalar(concat!(
            "SELECT EXISTS (SELECT 1 FROM keys WHERE id = $1 AND ",
            good!(),
            ")"
        ))
        .bind(owner.as_str())
        .fetch_one(&self.reads)
        .await?)
    }

    async fn has_keys(&self) -> Result<bool, StoreError> {
        Ok(sqlx::query_scalar(concat!(
            "SELECT EXISTS (SELECT 1 FROM keys WHERE ",
            good!(),
            ")"
        ))
        .fetch_one(&self.reads)
        .await?)
    }
}
