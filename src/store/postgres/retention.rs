//! What is kept no longer. Every server sweeps; what one takes, the others pass over.

use std::time::Duration;

use async_trait::async_trait;

use super::Postgres;
use super::connections::{PATIENCE, within};
use super::submissions::remembered;
use crate::store::microseconds;
use crate::store::retention::BATCH;
use crate::store::{Expired, Owner, Retention, StoreError};
use crate::wire::JobId;

#[async_trait]
impl Retention for Postgres {
    async fn expire(&self, retention: Duration) -> Result<Expired, StoreError> {
        let age = microseconds(retention);
        let mut jobs = 0;
        loop {
            let removed = within(PATIENCE, self.expire_jobs(age)).await?;
            jobs += removed;
            if removed < u64::from(BATCH) {
                break;
            }
        }
        // A job is never older than its batch, so that old batches alone can have lost theirs.
        self.forget(
            "WITH old AS (SELECT id, owner FROM batches WHERE created_at <= now_us() - $1 \
                          AND NOT EXISTS (SELECT 1 FROM jobs WHERE batch_id = batches.id) \
                          LIMIT $2 FOR UPDATE SKIP LOCKED), \
             noted AS (INSERT INTO expired (id, owner, expired_at) SELECT id, owner, now_us() FROM old \
                       ON CONFLICT DO NOTHING) \
             DELETE FROM batches USING old WHERE batches.id = old.id",
            age,
        )
        .await?;
        let meshes = self.expire_meshes(age).await?;
        self.forget(
            "DELETE FROM expired WHERE id IN \
             (SELECT id FROM expired WHERE expired_at <= now_us() - $1 LIMIT $2 FOR UPDATE SKIP LOCKED)",
            age,
        )
        .await?;
        Ok(Expired { jobs, meshes })
    }

    async fn forget_submissions(&self) -> Result<(), StoreError> {
        self.forget(
            "DELETE FROM submissions WHERE (owner, key) IN (SELECT owner, key FROM submissions \
             WHERE created_at <= now_us() - $1 LIMIT $2 FOR UPDATE SKIP LOCKED)",
            remembered(),
        )
        .await
    }

    async fn has_expired(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError> {
        self.has_expired_id(owner, &id.to_string()).await
    }
}

impl Postgres {
    /// Whether a job or a batch of this id was here and has expired.
    pub(super) async fn has_expired_id(&self, owner: &Owner, id: &str) -> Result<bool, StoreError> {
        Ok(
            sqlx::query_scalar(
                "SELECT EXISTS (SELECT 1 FROM expired WHERE id = $1 AND owner = $2)",
            )
            .bind(id)
            .bind(owner.as_str())
            .fetch_one(&self.reads)
            .await?,
        )
    }

    async fn expire_jobs(&self, age: i64) -> Result<u64, StoreError> {
        let removed = sqlx::query(
            "WITH old AS (SELECT id, owner FROM jobs WHERE finished_at <= now_us() - $1 \
                          ORDER BY finished_at LIMIT $2 FOR UPDATE SKIP LOCKED), \
             noted AS (INSERT INTO expired (id, owner, expired_at) SELECT id, owner, now_us() FROM old \
                       ON CONFLICT DO NOTHING) \
             DELETE FROM jobs USING old WHERE jobs.id = old.id",
        )
        .bind(age)
        .bind(i64::from(BATCH))
        .execute(&self.writes)
        .await?;
        Ok(removed.rows_affected())
    }

    async fn expire_meshes(&self, age: i64) -> Result<u64, StoreError> {
        let unused: Vec<(String, String)> = sqlx::query_as(
            "SELECT owner, id FROM meshes WHERE used_at <= now_us() - $1 AND NOT EXISTS \
             (SELECT 1 FROM jobs WHERE jobs.owner = meshes.owner AND jobs.mesh_id = meshes.id)",
        )
        .bind(age)
        .fetch_all(&self.writes)
        .await?;
        let mut removed = 0;
        for (owner, id) in unused {
            removed += u64::from(within(PATIENCE, self.expire_mesh(&owner, &id, age)).await?);
        }
        // Those of meshes that were forgotten by someone who died then, too.
        let orphans: Vec<Vec<u8>> = sqlx::query_scalar(
            "SELECT digest FROM files WHERE NOT EXISTS \
             (SELECT 1 FROM meshes WHERE meshes.digest = files.digest) LIMIT $1",
        )
        .bind(i64::from(BATCH))
        .fetch_all(&self.writes)
        .await?;
        self.drop_files(&orphans).await?;
        Ok(removed)
    }

    /// Removes a mesh, unless it was used since it was found.
    async fn expire_mesh(&self, owner: &str, id: &str, age: i64) -> Result<bool, StoreError> {
        let mut transaction = self.writes.begin().await?;
        // Waits for whoever is submitting a job on it, so that the next statement sees that job.
        sqlx::query("SELECT 1 FROM meshes WHERE owner = $1 AND id = $2 FOR UPDATE")
            .bind(owner)
            .bind(id)
            .execute(&mut *transaction)
            .await?;
        let removed = sqlx::query(
            "DELETE FROM meshes WHERE owner = $1 AND id = $2 AND used_at <= now_us() - $3 \
             AND NOT EXISTS (SELECT 1 FROM jobs WHERE owner = $1 AND mesh_id = $2)",
        )
        .bind(owner)
        .bind(id)
        .bind(age)
        .execute(&mut *transaction)
        .await?;
        transaction.commit().await?;
        Ok(removed.rows_affected() > 0)
    }

    /// Runs a deletion that takes an age and a number of rows until it finds no more.
    async fn forget(&self, statement: &'static str, age: i64) -> Result<(), StoreError> {
        loop {
            let removed = sqlx::query(statement)
                .bind(age)
                .bind(i64::from(BATCH))
                .execute(&self.writes)
                .await?;
            if removed.rows_affected() < u64::from(BATCH) {
                return Ok(());
            }
        }
    }
}
