//! API keys.

use async_trait::async_trait;

use super::connections::Connections;
use super::jobs::cancel;
use super::{Sqlite, now};
use crate::store::StoreError;
use crate::store::common::keys::{AccessEngine, KeyEngine};

/// Whether a key is good at `$1`.
macro_rules! is_good {
    () => {
        "revoked_at IS NULL AND (expires_at IS NULL OR expires_at > $1)"
    };
}

/// The API keys of a data directory, which a server may be using at the same time.
#[derive(Debug, Clone)]
pub struct SqliteKeys {
    pub(super) connection: Connections,
}

#[async_trait]
impl KeyEngine for SqliteKeys {
    async fn insert_key(
        &self,
        id: &str,
        hash: &[u8],
        name: &str,
        expires_at: Option<i64>,
    ) -> Result<i64, StoreError> {
        let created_at = now();
        let statement = sqlx::query(
            "INSERT INTO keys (id, name, hash, created_at, expires_at) VALUES ($1, $2, $3, $4, $5)",
        )
        .bind(id)
        .bind(name)
        .bind(hash)
        .bind(created_at)
        .bind(expires_at);
        self.connection.run(statement).await?;
        Ok(created_at)
    }

    async fn cancel_jobs_of(&self, owner: &str) -> Result<u64, StoreError> {
        let statement = sqlx::query(concat!(
            cancel!(),
            "WHERE owner = $1 AND state IN ('queued', 'running')"
        ));
        let answer = self
            .connection
            .run(statement.bind(owner).bind(now()))
            .await?;
        Ok(answer.changed())
    }

    async fn revoke_key(&self, id: &str) -> Result<u64, StoreError> {
        let statement =
            sqlx::query("UPDATE keys SET revoked_at = coalesce(revoked_at, $2) WHERE id = $1");
        let answer = self.connection.run(statement.bind(id).bind(now())).await?;
        Ok(answer.changed())
    }
}

#[async_trait]
impl AccessEngine for Sqlite {
    async fn hash_of(&self, id: &str) -> Result<Option<Vec<u8>>, StoreError> {
        let statement = sqlx::query(concat!(
            "SELECT hash FROM keys WHERE id = $2 AND ",
            is_good!()
        ));
        let answer = self.readers.read(statement.bind(now()).bind(id)).await?;
        Ok(answer.first()?.map(|(hash,)| hash))
    }

    async fn has_any_key(&self) -> Result<bool, StoreError> {
        let statement = sqlx::query(concat!(
            "SELECT EXISTS (SELECT 1 FROM keys WHERE ",
            is_good!(),
            ")"
        ));
        let (any,) = self.readers.read(statement.bind(now())).await?.one()?;
        Ok(any)
    }
}
