//! What is kept no longer.

use std::time::Duration;

use async_trait::async_trait;

use super::submissions::forgotten_before;
use super::{Sqlite, now};
use crate::store::common::retention::{self, repeat};
use crate::store::common::rows;
use crate::store::microseconds;
use crate::store::retention::BATCH;
use crate::store::{Expired, Owner, Retention, StoreError};
use crate::wire::JobId;

#[async_trait]
impl Retention for Sqlite {
    async fn expire(&self, retention: Duration) -> Result<Expired, StoreError> {
        let before = now().saturating_sub(microseconds(retention));
        // A sweep makes room, so that it has to work on a full disk.
        let jobs = repeat(|| self.with_reserve(|| self.expire_jobs(before))).await;
        let batches = repeat(|| self.with_reserve(|| self.expire_batches(before))).await;
        // Whatever became of the jobs: the files of meshes are most of what there is.
        let meshes = self.expire_meshes(before).await?;
        let jobs = jobs?;
        batches?;
        self.forget(
            "DELETE FROM expired WHERE id IN \
             (SELECT id FROM expired WHERE expired_at <= $1 LIMIT $2)",
            before,
        )
        .await?;
        Ok(Expired { jobs, meshes })
    }

    async fn forget_submissions(&self) -> Result<(), StoreError> {
        self.forget(
            "DELETE FROM submissions WHERE (owner, key) IN \
             (SELECT owner, key FROM submissions WHERE created_at <= $1 LIMIT $2)",
            forgotten_before(),
        )
        .await
    }

    async fn has_expired(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError> {
        retention::has_expired(self, owner, id.to_string()).await
    }
}

impl Sqlite {
    async fn expire_jobs(&self, before: i64) -> Result<u64, StoreError> {
        let mut transaction = self.writer.begin().await?;
        let note = sqlx::query(
            "INSERT OR IGNORE INTO expired (id, owner, expired_at) SELECT id, owner, $2 FROM jobs \
             WHERE finished_at <= $1 ORDER BY finished_at LIMIT $3",
        );
        let note = note.bind(before).bind(now()).bind(BATCH);
        transaction.run(note).await?;
        let remove = sqlx::query(
            "DELETE FROM jobs WHERE id IN \
             (SELECT id FROM jobs WHERE finished_at <= $1 ORDER BY finished_at LIMIT $2)",
        );
        let removed = transaction.run(remove.bind(before).bind(BATCH)).await?;
        transaction.end(true).await?;
        Ok(removed.changed())
    }

    /// Removes batches of which no job is left.
    async fn expire_batches(&self, before: i64) -> Result<u64, StoreError> {
        let mut transaction = self.writer.begin().await?;
        // A job is never older than its batch, so that old batches alone can have lost theirs.
        let remove = sqlx::query(
            "DELETE FROM batches WHERE id IN (SELECT id FROM batches WHERE created_at <= $1 \
             AND NOT EXISTS (SELECT 1 FROM jobs WHERE batch_id = batches.id) LIMIT $2) \
             RETURNING id, owner",
        );
        let remove = remove.bind(before).bind(BATCH);
        let removed: Vec<(String, String)> = transaction.run(remove).await?.all()?;
        for (id, owner) in &removed {
            let note = sqlx::query(
                "INSERT OR IGNORE INTO expired (id, owner, expired_at) VALUES ($1, $2, $3)",
            );
            transaction
                .run(note.bind(id).bind(owner).bind(now()))
                .await?;
        }
        transaction.end(true).await?;
        Ok(removed.len() as u64)
    }

    async fn expire_meshes(&self, before: i64) -> Result<u64, StoreError> {
        let unused = sqlx::query(
            "SELECT owner, id FROM meshes WHERE used_at <= $1 AND NOT EXISTS \
             (SELECT 1 FROM jobs WHERE jobs.owner = meshes.owner AND jobs.mesh_id = meshes.id)",
        );
        let unused: Vec<(String, String)> = self.readers.read(unused.bind(before)).await?.all()?;
        let mut removed = 0;
        for (owner, id) in unused {
            let id = rows::mesh_id(&id)?;
            let _guard = self.mesh_change.lock().await;
            // It may have been used since it was found.
            let remove = sqlx::query(
                "DELETE FROM meshes WHERE owner = $1 AND id = $2 AND used_at <= $3 AND NOT EXISTS \
                 (SELECT 1 FROM jobs WHERE owner = $1 AND mesh_id = $2)",
            );
            let remove = remove.bind(owner).bind(id.as_str()).bind(before);
            let rows = self.writer.run(remove).await?.changed();
            removed += rows;
            if rows > 0 {
                self.remove_unowned_file(&id).await?;
            }
        }
        Ok(removed)
    }

    /// Repeats a deletion that takes a moment and a number of rows until it finds no more.
    async fn forget(&self, statement: &'static str, before: i64) -> Result<(), StoreError> {
        let forget = || async {
            let statement = sqlx::query(statement).bind(before).bind(BATCH);
            Ok(self.writer.run(statement).await?.changed())
        };
        repeat(forget).await.map(drop)
    }
}
