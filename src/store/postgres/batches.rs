//! Batches: many jobs as one.
//!
//! No statement here locks more than one running job: workers renew many leases in one statement, and two such
//! statements could wait for each other.

use std::collections::HashSet;
use std::time::Duration;

use async_trait::async_trait;

use super::connections::{Transaction, within};
use super::jobs::{FORMAT, cancel, count_alone};
use super::{Postgres, submissions};
use crate::store::common::batches::BatchEngine;
use crate::store::common::rows;
use crate::store::{Jobs, NewBatch, Owner, Refusal, StoreError};
use crate::wire::{BatchId, JobId};

/// Longest time that the submission of a batch may take.
const SUBMISSION_TIME: Duration = Duration::from_secs(18);

#[async_trait]
impl BatchEngine for Postgres {
    const RESULTS: &'static str = "SELECT id, batch_index, mesh_id, label, state, problem, \
        (SELECT convert_from(string_agg(data, ''::bytea ORDER BY number), 'UTF8') FROM results \
         WHERE job_id = jobs.id) AS result \
        FROM jobs";

    async fn insert_batch(
        &self,
        id: BatchId,
        batch: &NewBatch,
    ) -> Result<Option<Refusal>, StoreError> {
        within(SUBMISSION_TIME, async {
            let mut transaction = self.writes.begin().await?;
            let refusal = insert(id, batch, &mut transaction).await?;
            transaction.end(refusal.is_none()).await?;
            Ok(refusal)
        })
        .await
    }

    async fn cancel_jobs_of_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Vec<(String, i64)>, StoreError> {
        let statement = sqlx::query(concat!(
            cancel!(),
            "WHERE batch_id = $1 AND owner = $2 AND state = 'queued' RETURNING id, revision"
        ));
        let statement = statement.bind(id.to_string()).bind(owner.as_str());
        let mut changed: Vec<(String, i64)> = self.writes.run(statement).await?.all()?;
        let statement = sqlx::query(
            "SELECT id FROM jobs WHERE batch_id = $1 AND owner = $2 \
             AND state IN ('queued', 'running') AND NOT cancel_requested",
        );
        let statement = statement.bind(id.to_string()).bind(owner.as_str());
        let running: Vec<(String,)> = self.writes.run(statement).await?.all()?;
        for (job,) in running {
            let record = self.cancel(owner, rows::job_id(&job)?).await?;
            changed.extend(record.map(|record| (job, record.revision as i64)));
        }
        Ok(changed)
    }

    async fn remove_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Option<Vec<String>>, StoreError> {
        let statement = |text: &'static str| {
            let statement = sqlx::query(text);
            statement.bind(id.to_string()).bind(owner.as_str())
        };
        let resting = statement(
            "DELETE FROM jobs WHERE batch_id = $1 AND owner = $2 AND state <> 'running' RETURNING id",
        );
        let mut jobs: Vec<(String,)> = self.writes.run(resting).await?.all()?;
        let others = statement("SELECT id FROM jobs WHERE batch_id = $1 AND owner = $2");
        let others: Vec<(String,)> = self.writes.run(others).await?.all()?;
        for (job,) in &others {
            self.delete_job(owner, rows::job_id(job)?).await?;
        }
        jobs.extend(others);
        // Last, so that a removal that was cut off can be asked for again.
        let batch = statement("DELETE FROM batches WHERE id = $1 AND owner = $2");
        let was_there = self.writes.run(batch).await?.changed() > 0;
        Ok(was_there.then(|| jobs.into_iter().map(|(id,)| id).collect()))
    }
}

/// Queues the jobs of a batch, or says why not all of them may be. Their meshes stay until the transaction ends.
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
    // Single jobs wait for this lock only where little room is left: those that come at the same moment may come on
    // top.
    count_alone(transaction).await?;
    let count = sqlx::query(
        "SELECT (SELECT count(*) FROM jobs WHERE state = 'queued'), \
         (SELECT count(*) FROM jobs WHERE state = 'queued' \
          AND priority IN ('interactive', 'batch') AND owner = $1)",
    )
    .bind(owner.as_str());
    let (queued, of_owner) = transaction.run(count).await?.one()?;
    if let Some(refusal) = batch.refusal(queued, of_owner) {
        return Ok(Some(refusal));
    }
    let meshes: HashSet<&str> = jobs.iter().map(|job| job.mesh_id.as_str()).collect();
    let meshes: Vec<&str> = meshes.into_iter().collect();
    // In the order of their ids, so that two batches never wait for each other.
    let lock = sqlx::query(
        "SELECT 1 FROM meshes WHERE owner = $1 AND id = ANY($2) ORDER BY id FOR KEY SHARE",
    );
    let lock = lock.bind(owner.as_str()).bind(&meshes);
    if transaction.run(lock).await?.changed() != meshes.len() as u64 {
        return Ok(Some(Refusal::UnknownMesh));
    }
    let statement = sqlx::query(
        "INSERT INTO batches (id, owner, label, jobs, created_at) \
         VALUES ($1, $2, $3, $4, now_us()) RETURNING created_at",
    )
    .bind(id.to_string())
    .bind(owner.as_str())
    .bind(label.as_deref())
    .bind(jobs.len() as i64);
    let (created_at,) = transaction.run(statement).await?.one::<(i64,)>()?;
    let ids: Vec<String> = jobs.iter().map(|_| JobId::new().to_string()).collect();
    let mesh_ids: Vec<&str> = jobs.iter().map(|job| job.mesh_id.as_str()).collect();
    let priorities: Vec<&str> = jobs.iter().map(|job| job.priority.name()).collect();
    let labels: Vec<Option<&str>> = jobs.iter().map(|job| job.label.as_deref()).collect();
    let requests: Vec<&str> = jobs.iter().map(|job| job.request.as_str()).collect();
    let statement = sqlx::query(
        "INSERT INTO jobs (id, owner, mesh_id, state, priority, format, created_at, label, request, \
         batch_id, batch_index) \
         SELECT id, $1, mesh_id, 'queued', priority, $2, $3, label, request, $4, place - 1 \
         FROM unnest($5::text[], $6::text[], $7::text[], $8::text[], $9::text[]) WITH ORDINALITY \
         AS job (id, mesh_id, priority, label, request, place) ORDER BY place",
    )
    .bind(owner.as_str())
    .bind(FORMAT)
    .bind(created_at)
    .bind(id.to_string())
    .bind(ids)
    .bind(mesh_ids)
    .bind(priorities)
    .bind(labels)
    .bind(requests);
    transaction.run(statement).await?;
    if let Some(submission) = submission
        && !submissions::insert(submission, owner, id.into(), transaction).await?
    {
        return Ok(Some(Refusal::KeyInUse));
    }
    let use_meshes = sqlx::query(
        "UPDATE meshes SET used_at = now_us() \
         WHERE owner = $1 AND id = ANY($2) AND used_at < now_us() - 1000000",
    );
    let use_meshes = use_meshes.bind(owner.as_str()).bind(meshes);
    transaction.run(use_meshes).await?;
    Ok(None)
}
