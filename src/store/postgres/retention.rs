//! What is kept no longer. Every server sweeps; what one takes, the others pass over.

use std::time::Duration;

use async_trait::async_trait;

use super::Postgres;
use super::connections::{PATIENCE, within};
use crate::store::common::retention::{self, repeat};
use crate::store::common::submissions::REMEMBERED;
use crate::store::microseconds;
use crate::store::retention::BATCH;
use crate::store::{Expired, Owner, Retention, StoreError};
use crate::wire::JobId;

#[async_trait]
impl Retention for Postgres {
    async fn expire(&self, retention: Duration) -> Result<Expired, StoreError> {
        let age = microseconds(retention);
        let jobs = self.forget(
            "WITH old AS (SELECT id, owner FROM jobs WHERE finished_at <= now_us() - $1 \
                          ORDER BY finished_at LIMIT $2 FOR UPDATE SKIP LOCKED), \
             noted AS (INSERT INTO expired (id, owner, expired_at) SELECT id, owner, now_us() FROM old \
                       ON CONFLICT DO NOTHING) \
             DELETE FROM jobs USING old WHERE jobs.id = old.id",
            age,
        );
        let jobs = jobs.await?;
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
            REMEMBERED,
        )
        .await
        .map(drop)
    }

    async fn has_expired(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError> {
        retention::has_expired(self, owner, id.to_string()).await
    }
}

impl Postgres {
    async fn expire_meshes(&self, age: i64) -> Result<u64, StoreError> {
        let unused = sqlx::query(
            "SELECT owner, id FROM meshes WHERE used_at <= now_us() - $1 AND NOT EXISTS \
             (SELECT 1 FROM jobs WHERE jobs.owner = meshes.owner AND jobs.mesh_id = meshes.id)",
        );
        let unused: Vec<(String, String)> = self.writes.run(unused.bind(age)).await?.all()?;
        let mut removed = 0;
        for (owner, id) in unused {
            removed += within(PATIENCE, self.expire_mesh(&owner, &id, age)).await?;
        }
        // Those of meshes that were forgotten by a process that died at that moment, too.
        let orphans = sqlx::query(
            "SELECT digest FROM files WHERE NOT EXISTS \
             (SELECT 1 FROM meshes WHERE meshes.digest = files.digest) LIMIT $1",
        );
        let orphans = orphans.bind(i64::from(BATCH));
        let orphans: Vec<(Vec<u8>,)> = self.writes.run(orphans).await?.all()?;
        for (digest,) in orphans {
            self.remove_unowned_file(&digest).await?;
        }
        Ok(removed)
    }

    /// Removes a mesh, unless it was used since it was found. Returns how many there were.
    async fn expire_mesh(&self, owner: &str, id: &str, age: i64) -> Result<u64, StoreError> {
        let mut transaction = self.writes.begin().await?;
        // Waits for whoever is submitting a job on it, so that the next statement sees that job.
        let lock = sqlx::query("SELECT 1 FROM meshes WHERE owner = $1 AND id = $2 FOR UPDATE");
        transaction.run(lock.bind(owner).bind(id)).await?;
        let remove = sqlx::query(
            "DELETE FROM meshes WHERE owner = $1 AND id = $2 AND used_at <= now_us() - $3 \
             AND NOT EXISTS (SELECT 1 FROM jobs WHERE owner = $1 AND mesh_id = $2)",
        );
        let remove = remove.bind(owner).bind(id).bind(age);
        let removed = transaction.run(remove).await?.changed();
        transaction.end(true).await?;
        Ok(removed)
    }

    /// Repeats a deletion that takes an age and a number of rows until it finds no more. Returns how many there
    /// were.
    async fn forget(&self, statement: &'static str, age: i64) -> Result<u64, StoreError> {
        let forget = || async {
            let statement = sqlx::query(statement).bind(age).bind(i64::from(BATCH));
            Ok(self.writes.run(statement).await?.changed())
        };
        repeat(forget).await
    }
}
