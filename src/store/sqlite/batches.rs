//! Batches: many jobs as one.

use async_trait::async_trait;

use super::connections::Transaction;
use super::jobs::cancel;
use super::{Sqlite, now, submissions};
use crate::store::common::batches::BatchEngine;
use crate::store::{NewBatch, Owner, Refusal, StoreError, damaged};
use crate::wire::{BatchId, JobId};

#[async_trait]
impl BatchEngine for Sqlite {
    const RESULTS: &'static str = "SELECT id, batch_index, mesh_id, label, state, problem, result \
        FROM jobs INDEXED BY jobs_in_batch";

    async fn insert_batch(
        &self,
        id: BatchId,
        batch: &NewBatch,
    ) -> Result<Option<Refusal>, StoreError> {
        let mut transaction = self.writer.begin().await?;
        let refusal = insert(id, batch, &mut transaction).await?;
        transaction.end(refusal.is_none()).await?;
        Ok(refusal)
    }

    async fn cancel_jobs_of_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Vec<(String, i64)>, StoreError> {
        let cancel = || async {
            let statement = sqlx::query(concat!(
                cancel!(),
                "WHERE batch_id = $1 AND owner = $3 AND state IN ('queued', 'running') \
                 AND NOT cancel_requested RETURNING id, revision"
            ))
            .bind(id.to_string())
            .bind(now())
            .bind(owner.as_str());
            self.writer.run(statement).await?.all()
        };
        self.with_reserve(cancel).await
    }

    async fn remove_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Option<Vec<String>>, StoreError> {
        let remove = || async {
            let mut transaction = self.writer.begin().await?;
            let batch = sqlx::query("DELETE FROM batches WHERE id = $1 AND owner = $2")
                .bind(id.to_string())
                .bind(owner.as_str());
            let was_there = transaction.run(batch).await?.changed() > 0;
            let jobs =
                sqlx::query("DELETE FROM jobs WHERE batch_id = $1 AND owner = $2 RETURNING id")
                    .bind(id.to_string())
                    .bind(owner.as_str());
            let jobs: Vec<(String,)> = transaction.run(jobs).await?.all()?;
            transaction.end(true).await?;
            Ok(was_there.then(|| jobs.into_iter().map(|(id,)| id).collect()))
        };
        self.with_reserve(remove).await
    }
}

/// Queues the jobs of a batch, or says why not all of them may be.
async fn insert(
    id: BatchId,
    batch: &NewBatch,
    transaction: &mut Transaction,
) -> Result<Option<Refusal>, StoreError> {
    let NewBatch {
        owner,
        label,
        jobs,
        submission,
        ..
    } = batch;
    let count = sqlx::query(
        "SELECT (SELECT jobs FROM job_counts WHERE state = 'queued'), \
         (SELECT count(*) FROM jobs WHERE state = 'queued' \
          AND priority IN ('interactive', 'batch') AND owner = $1)",
    )
    .bind(owner.as_str());
    let (queued, of_owner) = transaction.run(count).await?.one()?;
    if let Some(refusal) = batch.refusal(queued, of_owner) {
        return Ok(Some(refusal));
    }
    let created_at = now();
    let statement = sqlx::query(
        "INSERT INTO batches (id, owner, label, jobs, created_at) VALUES ($1, $2, $3, $4, $5)",
    )
    .bind(id.to_string())
    .bind(owner.as_str())
    .bind(label.as_deref())
    .bind(jobs.len() as i64)
    .bind(created_at);
    transaction.run(statement).await?;
    let rows: Vec<_> = jobs
        .iter()
        .map(|job| {
            let (mesh, priority) = (job.mesh_id.as_str(), job.priority.name());
            (JobId::new(), mesh, priority, &job.label, &job.request)
        })
        .collect();
    // One statement for all jobs: nobody else can write while it runs.
    let statement = sqlx::query(
        "INSERT INTO jobs (id, owner, mesh_id, state, priority, created_at, label, request, \
         batch_id, batch_index) \
         SELECT value ->> 0, $2, value ->> 1, 'queued', value ->> 2, $3, value ->> 3, value ->> 4, \
         $4, key FROM json_each($1) \
         WHERE EXISTS (SELECT 1 FROM meshes WHERE owner = $2 AND id = value ->> 1)",
    )
    .bind(serde_json::to_string(&rows).map_err(damaged)?)
    .bind(owner.as_str())
    .bind(created_at)
    .bind(id.to_string());
    if transaction.run(statement).await?.changed() != jobs.len() as u64 {
        return Ok(Some(Refusal::UnknownMesh));
    }
    if let Some(submission) = submission
        && !submissions::insert(submission, owner, id.into(), created_at, transaction).await?
    {
        return Ok(Some(Refusal::KeyInUse));
    }
    Ok(None)
}
