//! What is kept no longer.

use std::time::Duration;

use async_trait::async_trait;
use sqlx::Row;

use super::submissions::forgotten_before;
use super::{Sqlite, blocking, now};
use crate::store::microseconds;
use crate::store::retention::BATCH;
use crate::store::{Expired, Owner, Retention, StoreError, rows};
use crate::wire::{JobId, MeshId};

#[async_trait]
impl Retention for Sqlite {
    async fn expire(&self, retention: Duration) -> Result<Expired, StoreError> {
        let before = now().saturating_sub(microseconds(retention));
        let mut jobs = 0;
        let removed = loop {
            // Room is what this makes, so that it has to work on a full disk.
            match self.with_reserve(|| self.expire_jobs(before)).await {
                Ok(removed) => {
                    jobs += removed;
                    if removed < u64::from(BATCH) {
                        break Ok(());
                    }
                }
                Err(error) => break Err(error),
            }
        };
        let emptied = self.with_reserve(|| self.expire_batches(before)).await;
        // Whatever became of the jobs: the files of meshes are most of what there is.
        let meshes = self.expire_meshes(before).await?;
        removed?;
        emptied?;
        self.forget_old(
            "DELETE FROM expired WHERE id IN \
             (SELECT id FROM expired WHERE expired_at <= ?1 LIMIT ?2)",
            before,
        )
        .await?;
        Ok(Expired { jobs, meshes })
    }

    async fn forget_submissions(&self) -> Result<(), StoreError> {
        self.forget_old(
            "DELETE FROM submissions WHERE (owner, key) IN \
             (SELECT owner, key FROM submissions WHERE created_at <= ?1 LIMIT ?2)",
            forgotten_before(),
        )
        .await
    }

    async fn has_expired(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError> {
        self.has_expired_id(owner, &id.to_string()).await
    }
}

impl Sqlite {
    /// Whether a job or a batch of this id was here and has expired.
    pub(super) async fn has_expired_id(&self, owner: &Owner, id: &str) -> Result<bool, StoreError> {
        Ok(
            sqlx::query_scalar(
                "SELECT EXISTS (SELECT 1 FROM expired WHERE id = ?1 AND owner = ?2)",
            )
            .bind(id)
            .bind(owner.as_str())
            .fetch_one(&self.readers)
            .await?,
        )
    }

    /// Removes the batches of which no job is left.
    async fn expire_batches(&self, before: i64) -> Result<(), StoreError> {
        loop {
            let mut transaction = self.writer.begin().await?;
            // A job is never older than its batch, so that old batches alone can have lost theirs.
            let removed = sqlx::query(
                "DELETE FROM batches WHERE id IN (SELECT id FROM batches WHERE created_at <= ?1 \
                 AND NOT EXISTS (SELECT 1 FROM jobs WHERE batch_id = batches.id) LIMIT ?2) \
                 RETURNING id, owner",
            )
            .bind(before)
            .bind(BATCH)
            .fetch_all(&mut *transaction)
            .await?;
            for row in &removed {
                sqlx::query(
                    "INSERT OR IGNORE INTO expired (id, owner, expired_at) VALUES (?1, ?2, ?3)",
                )
                .bind(row.try_get::<&str, _>("id")?)
                .bind(row.try_get::<&str, _>("owner")?)
                .bind(now())
                .execute(&mut *transaction)
                .await?;
            }
            transaction.commit().await?;
            if removed.len() < BATCH as usize {
                return Ok(());
            }
        }
    }

    async fn expire_jobs(&self, before: i64) -> Result<u64, StoreError> {
        let mut transaction = self.writer.begin().await?;
        sqlx::query(
            "INSERT OR IGNORE INTO expired (id, owner, expired_at) SELECT id, owner, ?2 FROM jobs \
             WHERE finished_at <= ?1 ORDER BY finished_at LIMIT ?3",
        )
        .bind(before)
        .bind(now())
        .bind(BATCH)
        .execute(&mut *transaction)
        .await?;
        let removed = sqlx::query(
            "DELETE FROM jobs WHERE id IN \
             (SELECT id FROM jobs WHERE finished_at <= ?1 ORDER BY finished_at LIMIT ?2)",
        )
        .bind(before)
        .bind(BATCH)
        .execute(&mut *transaction)
        .await?;
        transaction.commit().await?;
        Ok(removed.rows_affected())
    }

    async fn expire_meshes(&self, before: i64) -> Result<u64, StoreError> {
        let unused: Vec<(String, String)> = sqlx::query_as(
            "SELECT owner, id FROM meshes WHERE used_at <= ?1 AND NOT EXISTS \
             (SELECT 1 FROM jobs WHERE jobs.owner = meshes.owner AND jobs.mesh_id = meshes.id)",
        )
        .bind(before)
        .fetch_all(&self.readers)
        .await?;
        let mut removed = 0;
        for (owner, id) in unused {
            let id = rows::mesh_id(&id)?;
            let _guard = self.mesh_change.lock().await;
            // It may have been used since it was found.
            let deleted = sqlx::query(
                "DELETE FROM meshes WHERE owner = ?1 AND id = ?2 AND used_at <= ?3 AND NOT EXISTS \
                 (SELECT 1 FROM jobs WHERE owner = ?1 AND mesh_id = ?2)",
            )
            .bind(owner)
            .bind(id.as_str())
            .bind(before)
            .execute(&self.writer)
            .await?;
            removed += deleted.rows_affected();
            if deleted.rows_affected() > 0 {
                self.drop_unowned_file(&id).await?;
            }
        }
        Ok(removed)
    }

    /// Removes the file of a mesh that is nobody's any more. The caller holds `mesh_change`.
    pub(super) async fn drop_unowned_file(&self, id: &MeshId) -> Result<(), StoreError> {
        if !self.is_anyones(id).await? {
            let (files, id) = (self.files.clone(), id.clone());
            blocking(move || files.remove(&id)).await?;
        }
        Ok(())
    }

    /// Runs a deletion that takes a moment and a number of rows until it finds no more.
    async fn forget_old(&self, statement: &'static str, before: i64) -> Result<(), StoreError> {
        loop {
            let removed = sqlx::query(statement)
                .bind(before)
                .bind(BATCH)
                .execute(&self.writer)
                .await?;
            if removed.rows_affected() < u64::from(BATCH) {
                return Ok(());
            }
        }
    }
}
