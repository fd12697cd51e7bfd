//! Batches: many jobs as one.

use std::collections::HashMap;

use async_trait::async_trait;

use super::jobs::JobEngine;
use super::rows::{self, BatchResultRow, BatchRow, MeshSummaryRow, ProgressRow};
use super::statement::Statement;
use super::{Engine, cursor, first, one, retention};
use crate::store::meshes::MeshSummary;
use crate::store::{Batches, NewBatch, Owner, Refusal, StoreError, damaged};
use crate::wire::{BatchId, BatchPage, BatchRecord, BatchResult, JobId, JobState, MeshId};

/// The operations on batches that each engine implements itself.
#[async_trait]
pub trait BatchEngine: JobEngine {
    /// The results of a batch, up to the condition on `batch_id`.
    const RESULTS: &'static str;

    /// Queues the jobs of a batch, or says why not all of them may be.
    async fn insert_batch(
        &self,
        id: BatchId,
        batch: &NewBatch,
    ) -> Result<Option<Refusal>, StoreError>;

    /// Ends the queued jobs of a batch and marks the running ones. Returns those that it changed, each with its
    /// revision.
    async fn cancel_jobs_of_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Vec<(String, i64)>, StoreError>;

    /// Forgets a batch and its jobs, and returns these; `None` when there is no such batch.
    async fn remove_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Option<Vec<String>>, StoreError>;
}

#[async_trait]
impl<E: BatchEngine> Batches for E {
    async fn mesh_summaries(
        &self,
        owner: &Owner,
        meshes: &[MeshId],
    ) -> Result<HashMap<MeshId, MeshSummary>, StoreError> {
        let ids = meshes.iter().map(|id| id.as_str().to_owned()).collect();
        let statement = Statement::new(
            "SELECT id, candidates, report, units, used_at FROM meshes WHERE owner = $1",
        )
        .bind(owner.as_str())
        .push_in_list::<E>(" AND id", ids);
        let rows: Vec<MeshSummaryRow> = self.read(statement).await?;
        let summary = |row: MeshSummaryRow| Ok((rows::mesh_id(&row.id)?, row.try_into()?));
        rows.into_iter().map(summary).collect()
    }

    async fn submit_batch(
        &self,
        batch: &NewBatch,
    ) -> Result<Result<BatchRecord, Refusal>, StoreError> {
        let id = BatchId::new();
        if let Some(refusal) = self.insert_batch(id, batch).await? {
            return Ok(Err(refusal));
        }
        let record = self.batch(&batch.owner, id).await?;
        Ok(Ok(record.ok_or_else(|| damaged("a batch that is gone"))?))
    }

    async fn batch(&self, owner: &Owner, id: BatchId) -> Result<Option<BatchRecord>, StoreError> {
        let statement = Statement::new(
            "SELECT id, label, jobs, created_at FROM batches WHERE id = $1 AND owner = $2",
        );
        let statement = statement.bind(id.to_string()).bind(owner.as_str());
        let row: Option<BatchRow> = first(self, statement).await?;
        let batches = with_progress(self, row.into_iter().collect()).await?;
        Ok(batches.into_iter().next())
    }

    async fn batches(
        &self,
        owner: &Owner,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<BatchPage>, StoreError> {
        const LIST: &str = "batches";
        let mut statement =
            Statement::new("SELECT id, label, jobs, created_at FROM batches WHERE owner = $1")
                .bind(owner.as_str());
        if let Some(cursor) = cursor {
            let Some(last) = cursor::decode(LIST, cursor).and_then(BatchId::parse) else {
                return Ok(None);
            };
            statement = statement.push(" AND id < ", last.to_string());
        }
        let limit = cursor::limit(limit);
        let statement = statement.push(" ORDER BY id DESC LIMIT ", limit.asked_for());
        let rows: Vec<BatchRow> = self.read(statement).await?;
        let (rows, next_cursor) = limit.page(LIST, rows, |row| row.id.clone());
        let batches = with_progress(self, rows).await?;
        Ok(Some(BatchPage {
            batches,
            next_cursor,
        }))
    }

    async fn unfinished(&self, id: BatchId) -> Result<Option<JobId>, StoreError> {
        let statement = Statement::new(
            "SELECT coalesce( \
             (SELECT max(id) FROM jobs WHERE batch_id = $1 AND state = 'queued'), \
             (SELECT max(id) FROM jobs WHERE batch_id = $1 AND state = 'running'))",
        );
        let (last,): (Option<String>,) = one(self, statement.bind(id.to_string())).await?;
        last.as_deref().map(rows::job_id).transpose()
    }

    async fn batch_results(
        &self,
        owner: &Owner,
        id: BatchId,
        state: Option<JobState>,
        after: Option<u32>,
        limit: u32,
    ) -> Result<Vec<BatchResult>, StoreError> {
        let mut statement = Statement::new(E::RESULTS)
            .push(" WHERE batch_id = ", id.to_string())
            .push(" AND owner = ", owner.as_str());
        if let Some(state) = state {
            statement = statement.push(" AND state = ", state.name());
        }
        if let Some(after) = after {
            statement = statement.push(" AND batch_index > ", after);
        }
        let statement = statement.push(" ORDER BY batch_index LIMIT ", limit);
        let rows: Vec<BatchResultRow> = self.read(statement).await?;
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
        let changed = self.cancel_jobs_of_batch(owner, id).await?;
        changed.iter().map(rows::job_and_revision).collect()
    }

    async fn delete_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Option<Vec<JobId>>, StoreError> {
        let Some(jobs) = self.remove_batch(owner, id).await? else {
            return Ok(None);
        };
        let jobs = jobs.iter().map(|id| rows::job_id(id));
        jobs.collect::<Result<_, _>>().map(Some)
    }

    async fn batch_has_expired(&self, owner: &Owner, id: BatchId) -> Result<bool, StoreError> {
        retention::has_expired(self, owner, id.to_string()).await
    }
}

impl NewBatch {
    /// Why the queue has no room for this batch, with so many jobs that wait and so many of its owner among them.
    pub(in crate::store) fn refusal(&self, queued: i64, of_owner: i64) -> Option<Refusal> {
        let jobs = self.jobs.len() as i64;
        if queued + jobs > i64::from(self.capacity) {
            return Some(Refusal::QueueFull);
        }
        let owner_capacity = self.owner_capacity?;
        (of_owner + jobs > i64::from(owner_capacity)).then_some(Refusal::OwnerQueueFull)
    }
}

/// Returns the records of batches, with the progress of each, in their order.
async fn with_progress<E: Engine>(
    engine: &E,
    batches: Vec<BatchRow>,
) -> Result<Vec<BatchRecord>, StoreError> {
    let ids = batches.iter().map(|batch| batch.id.clone()).collect();
    let statement = Statement::new(
        "SELECT batch_id, state, count(*) AS jobs, min(started_at) AS started_at, \
         max(finished_at) AS finished_at FROM jobs WHERE ",
    )
    .push_in_list::<E>("batch_id", ids)
    .push_text(" GROUP BY batch_id, state");
    let progress: Vec<ProgressRow> = engine.read(statement).await?;
    rows::batches(batches, &progress)
}
