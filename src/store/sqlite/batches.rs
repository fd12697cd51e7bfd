//! Batches: many jobs as one.

use std::collections::HashMap;

use async_trait::async_trait;
use sqlx::sqlite::SqliteConnection;
use sqlx::{FromRow, QueryBuilder, Row};

use super::jobs::cancel;
use super::{Sqlite, now, submissions};
use crate::store::meshes::Kept;
use crate::store::rows::{self, BatchResultRow, BatchRow, KeptRow, ProgressRow};
use crate::store::{Batches, MAX_PAGE, NewBatch, Owner, Refusal, StoreError, cursor, damaged};
use crate::wire::{BatchId, BatchPage, BatchRecord, BatchResult, JobId, JobState, MeshId};

#[async_trait]
impl Batches for Sqlite {
    async fn kept_among(
        &self,
        owner: &Owner,
        meshes: &[MeshId],
    ) -> Result<HashMap<MeshId, Kept>, StoreError> {
        let ids: Vec<&str> = meshes.iter().map(MeshId::as_str).collect();
        let rows = sqlx::query(
            "SELECT id, candidates, units, used_at FROM meshes \
             WHERE owner = ?1 AND id IN (SELECT value FROM json_each(?2))",
        )
        .bind(owner.as_str())
        .bind(serde_json::to_string(&ids).map_err(damaged)?)
        .fetch_all(&self.readers)
        .await?;
        let kept = rows.iter().map(|row| {
            let id = rows::mesh_id(row.try_get("id")?)?;
            Ok((id, KeptRow::from_row(row)?.try_into()?))
        });
        kept.collect()
    }

    async fn submit_batch(
        &self,
        batch: &NewBatch,
    ) -> Result<Result<BatchRecord, Refusal>, StoreError> {
        let id = BatchId::new();
        let mut transaction = self.writer.begin().await?;
        if let Some(refusal) = insert(id, batch, &mut transaction).await? {
            transaction.rollback().await?;
            return Ok(Err(refusal));
        }
        transaction.commit().await?;
        let record = self.batch(&batch.owner, id).await?;
        Ok(Ok(record.ok_or_else(|| damaged("a batch that is gone"))?))
    }

    async fn batch(&self, owner: &Owner, id: BatchId) -> Result<Option<BatchRecord>, StoreError> {
        let row: Option<BatchRow> = sqlx::query_as(
            "SELECT id, label, jobs, created_at FROM batches WHERE id = ?1 AND owner = ?2",
        )
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_optional(&self.readers)
        .await?;
        let batches = self.with_progress(row.into_iter().collect()).await?;
        Ok(batches.into_iter().next())
    }

    async fn batches(
        &self,
        owner: &Owner,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<BatchPage>, StoreError> {
        const LIST: &str = "batches";
        let limit = limit.clamp(1, MAX_PAGE) as usize;
        let mut query =
            QueryBuilder::new("SELECT id, label, jobs, created_at FROM batches WHERE owner = ");
        query.push_bind(owner.as_str());
        if let Some(cursor) = cursor {
            let Some(last) = cursor::decode(LIST, cursor).and_then(BatchId::parse) else {
                return Ok(None);
            };
            query.push(" AND id < ").push_bind(last.to_string());
        }
        query
            .push(" ORDER BY id DESC LIMIT ")
            .push_bind(limit as i64 + 1);
        let rows: Vec<BatchRow> = query.build_query_as().fetch_all(&self.readers).await?;
        let (rows, next_cursor) = cursor::page(LIST, rows, limit, |row| row.id.clone());
        let batches = self.with_progress(rows).await?;
        Ok(Some(BatchPage {
            batches,
            next_cursor,
        }))
    }

    async fn unfinished(&self, id: BatchId) -> Result<Option<JobId>, StoreError> {
        let last: Option<String> = sqlx::query_scalar(
            "SELECT coalesce( \
             (SELECT max(id) FROM jobs WHERE batch_id = ?1 AND state = 'queued'), \
             (SELECT max(id) FROM jobs WHERE batch_id = ?1 AND state = 'running'))",
        )
        .bind(id.to_string())
        .fetch_one(&self.readers)
        .await?;
        last.map(|id| rows::job_id(&id)).transpose()
    }

    async fn batch_results(
        &self,
        owner: &Owner,
        id: BatchId,
        state: Option<JobState>,
        after: Option<u32>,
        limit: u32,
    ) -> Result<Vec<BatchResult>, StoreError> {
        let mut query = QueryBuilder::new(
            "SELECT id, batch_index, mesh_id, label, state, problem, result FROM jobs \
             INDEXED BY jobs_in_batch WHERE batch_id = ",
        );
        query.push_bind(id.to_string());
        query.push(" AND owner = ").push_bind(owner.as_str());
        if let Some(state) = state {
            query.push(" AND state = ").push_bind(state.name());
        }
        if let Some(after) = after {
            query.push(" AND batch_index > ").push_bind(after);
        }
        query.push(" ORDER BY batch_index LIMIT ").push_bind(limit);
        let rows: Vec<BatchResultRow> = query.build_query_as().fetch_all(&self.readers).await?;
        let mut results = Vec::with_capacity(rows.len());
        for row in rows {
            results.push(row.into_result().await?);
        }
        Ok(results)
    }

    async fn cancel_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Vec<(JobId, u64)>, StoreError> {
        let cancel = || async {
            let statement = sqlx::query(concat!(
                cancel!(),
                "WHERE batch_id = ?1 AND owner = ?3 AND state IN ('queued', 'running') \
                 AND NOT cancel_requested RETURNING id, revision"
            ))
            .bind(id.to_string())
            .bind(now())
            .bind(owner.as_str());
            self.write_returning(statement).await
        };
        let rows = self.with_reserve(cancel).await?;
        let changed = rows.iter().map(|row| {
            let revision: i64 = row.try_get("revision")?;
            Ok((rows::job_id(row.try_get("id")?)?, revision as u64))
        });
        changed.collect()
    }

    async fn delete_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Option<Vec<JobId>>, StoreError> {
        let delete = || async {
            let mut transaction = self.writer.begin().await?;
            let batch = sqlx::query("DELETE FROM batches WHERE id = ?1 AND owner = ?2")
                .bind(id.to_string())
                .bind(owner.as_str())
                .execute(&mut *transaction)
                .await?;
            let rows =
                sqlx::query("DELETE FROM jobs WHERE batch_id = ?1 AND owner = ?2 RETURNING id")
                    .bind(id.to_string())
                    .bind(owner.as_str())
                    .fetch_all(&mut *transaction)
                    .await?;
            transaction.commit().await?;
            Ok((batch.rows_affected() > 0).then_some(rows))
        };
        let Some(rows) = self.with_reserve(delete).await? else {
            return Ok(None);
        };
        let jobs = rows.iter().map(|row| rows::job_id(row.try_get("id")?));
        jobs.collect::<Result<_, _>>().map(Some)
    }

    async fn batch_has_expired(&self, owner: &Owner, id: BatchId) -> Result<bool, StoreError> {
        self.has_expired_id(owner, &id.to_string()).await
    }
}

impl Sqlite {
    /// Records of batches, with the progress of each, in their order.
    async fn with_progress(&self, batches: Vec<BatchRow>) -> Result<Vec<BatchRecord>, StoreError> {
        let ids: Vec<&str> = batches.iter().map(|batch| batch.id.as_str()).collect();
        let progress: Vec<ProgressRow> = sqlx::query_as(
            "SELECT batch_id, state, count(*) AS jobs, min(started_at) AS started_at, \
             max(finished_at) AS finished_at FROM jobs \
             WHERE batch_id IN (SELECT value FROM json_each(?1)) GROUP BY batch_id, state",
        )
        .bind(serde_json::to_string(&ids).map_err(damaged)?)
        .fetch_all(&self.readers)
        .await?;
        rows::batches(batches, &progress)
    }
}

/// Queues the jobs of a batch, or says why not all of them may be.
async fn insert(
    id: BatchId,
    batch: &NewBatch,
    transaction: &mut SqliteConnection,
) -> Result<Option<Refusal>, StoreError> {
    let NewBatch {
        owner,
        label,
        jobs,
        capacity,
        share,
        submission,
    } = batch;
    let wanted = jobs.len() as i64;
    let (queued, own): (i64, i64) = sqlx::query_as(
        "SELECT (SELECT jobs FROM stock WHERE state = 'queued'), \
         (SELECT count(*) FROM jobs WHERE state = 'queued' \
          AND priority IN ('interactive', 'batch') AND owner = ?1)",
    )
    .bind(owner.as_str())
    .fetch_one(&mut *transaction)
    .await?;
    if queued + wanted > i64::from(*capacity) {
        return Ok(Some(Refusal::QueueFull));
    }
    if share.is_some_and(|share| own + wanted > i64::from(share)) {
        return Ok(Some(Refusal::ShareUsed));
    }
    let created_at = now();
    sqlx::query(
        "INSERT INTO batches (id, owner, label, jobs, created_at) VALUES (?1, ?2, ?3, ?4, ?5)",
    )
    .bind(id.to_string())
    .bind(owner.as_str())
    .bind(label.as_deref())
    .bind(wanted)
    .bind(created_at)
    .execute(&mut *transaction)
    .await?;
    let rows: Vec<_> = jobs
        .iter()
        .map(|job| {
            let id = JobId::new();
            (
                id,
                job.mesh_id.as_str(),
                job.priority.name(),
                &job.label,
                &job.request,
            )
        })
        .collect();
    // One statement, since the writer is everyone's while it runs.
    let inserted = sqlx::query(
        "INSERT INTO jobs (id, owner, mesh_id, state, priority, created_at, label, request, \
         batch_id, batch_index) \
         SELECT value ->> 0, ?2, value ->> 1, 'queued', value ->> 2, ?3, value ->> 3, value ->> 4, \
         ?4, key FROM json_each(?1) \
         WHERE EXISTS (SELECT 1 FROM meshes WHERE owner = ?2 AND id = value ->> 1)",
    )
    .bind(serde_json::to_string(&rows).map_err(damaged)?)
    .bind(owner.as_str())
    .bind(created_at)
    .bind(id.to_string())
    .execute(&mut *transaction)
    .await?;
    if inserted.rows_affected() != jobs.len() as u64 {
        return Ok(Some(Refusal::UnknownMesh));
    }
    if let Some(submission) = submission
        && !submissions::insert(submission, owner, id.into(), created_at, transaction).await?
    {
        return Ok(Some(Refusal::Submitted));
    }
    Ok(None)
}
