//! Batches: many jobs as one.
//!
//! No statement here locks more than one running job: workers renew many leases in one statement, and two such
//! statements could wait for each other.

use std::collections::{HashMap, HashSet};
use std::time::Duration;

use async_trait::async_trait;
use sqlx::postgres::PgConnection;
use sqlx::{FromRow, QueryBuilder, Row};

use super::connections::within;
use super::jobs::{COUNTING, FORMAT, cancel};
use super::{Postgres, submissions};
use crate::store::meshes::Kept;
use crate::store::rows::{self, BatchResultRow, BatchRow, KeptRow, ProgressRow};
use crate::store::{
    Batches, Jobs, MAX_PAGE, NewBatch, Owner, Refusal, StoreError, cursor, damaged,
};
use crate::wire::{BatchId, BatchPage, BatchRecord, BatchResult, JobId, JobState, MeshId};

/// Longest that the submission of one may take.
const SUBMISSION_TIME: Duration = Duration::from_secs(18);

#[async_trait]
impl Batches for Postgres {
    async fn kept_among(
        &self,
        owner: &Owner,
        meshes: &[MeshId],
    ) -> Result<HashMap<MeshId, Kept>, StoreError> {
        let ids: Vec<&str> = meshes.iter().map(MeshId::as_str).collect();
        let rows = sqlx::query(
            "SELECT id, candidates, units, used_at FROM meshes WHERE owner = $1 AND id = ANY($2)",
        )
        .bind(owner.as_str())
        .bind(ids)
        .fetch_all(&self.reads)
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
        let refusal = within(SUBMISSION_TIME, async {
            let mut transaction = self.writes.begin().await?;
            let refusal = insert(id, batch, &mut transaction).await?;
            match refusal {
                None => transaction.commit().await?,
                Some(_) => transaction.rollback().await?,
            }
            Ok(refusal)
        });
        if let Some(refusal) = refusal.await? {
            return Ok(Err(refusal));
        }
        let record = self.batch(&batch.owner, id).await?;
        Ok(Ok(record.ok_or_else(|| damaged("a batch that is gone"))?))
    }

    async fn batch(&self, owner: &Owner, id: BatchId) -> Result<Option<BatchRecord>, StoreError> {
        let row: Option<BatchRow> = sqlx::query_as(
            "SELECT id, label, jobs, created_at FROM batches WHERE id = $1 AND owner = $2",
        )
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_optional(&self.reads)
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
        let rows: Vec<BatchRow> = query.build_query_as().fetch_all(&self.reads).await?;
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
             (SELECT max(id) FROM jobs WHERE batch_id = $1 AND state = 'queued'), \
             (SELECT max(id) FROM jobs WHERE batch_id = $1 AND state = 'running'))",
        )
        .bind(id.to_string())
        .fetch_one(&self.reads)
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
            "SELECT id, batch_index, mesh_id, label, state, problem, \
             (SELECT convert_from(string_agg(data, ''::bytea ORDER BY number), 'UTF8') FROM results \
              WHERE job_id = jobs.id) AS result \
             FROM jobs WHERE batch_id = ",
        );
        query.push_bind(id.to_string());
        query.push(" AND owner = ").push_bind(owner.as_str());
        if let Some(state) = state {
            query.push(" AND state = ").push_bind(state.name());
        }
        if let Some(after) = after {
            query
                .push(" AND batch_index > ")
                .push_bind(i64::from(after));
        }
        query
            .push(" ORDER BY batch_index LIMIT ")
            .push_bind(i64::from(limit));
        let rows: Vec<BatchResultRow> = query.build_query_as().fetch_all(&self.reads).await?;
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
        let waiting = sqlx::query(concat!(
            cancel!(),
            "WHERE batch_id = $1 AND owner = $2 AND state = 'queued' RETURNING id, revision"
        ))
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_all(&self.writes)
        .await?;
        let mut changed = Vec::with_capacity(waiting.len());
        for row in &waiting {
            let revision: i64 = row.try_get("revision")?;
            changed.push((rows::job_id(row.try_get("id")?)?, revision as u64));
        }
        let running: Vec<String> = sqlx::query_scalar(
            "SELECT id FROM jobs WHERE batch_id = $1 AND owner = $2 \
             AND state IN ('queued', 'running') AND NOT cancel_requested",
        )
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_all(&self.writes)
        .await?;
        for job in running {
            let job = self.cancel(owner, rows::job_id(&job)?).await?;
            changed.extend(job.map(|job| (job.id, job.revision)));
        }
        Ok(changed)
    }

    async fn delete_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Option<Vec<JobId>>, StoreError> {
        let resting: Vec<String> = sqlx::query_scalar(
            "DELETE FROM jobs WHERE batch_id = $1 AND owner = $2 AND state <> 'running' RETURNING id",
        )
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_all(&self.writes)
        .await?;
        let others: Vec<String> =
            sqlx::query_scalar("SELECT id FROM jobs WHERE batch_id = $1 AND owner = $2")
                .bind(id.to_string())
                .bind(owner.as_str())
                .fetch_all(&self.writes)
                .await?;
        for job in &others {
            self.delete_job(owner, rows::job_id(job)?).await?;
        }
        // Last, so that what was cut off can be asked for again.
        let batch = sqlx::query("DELETE FROM batches WHERE id = $1 AND owner = $2")
            .bind(id.to_string())
            .bind(owner.as_str())
            .execute(&self.writes)
            .await?;
        if batch.rows_affected() == 0 {
            return Ok(None);
        }
        let jobs = resting.iter().chain(&others).map(|id| rows::job_id(id));
        jobs.collect::<Result<_, _>>().map(Some)
    }

    async fn batch_has_expired(&self, owner: &Owner, id: BatchId) -> Result<bool, StoreError> {
        self.has_expired_id(owner, &id.to_string()).await
    }
}

impl Postgres {
    /// Records of batches, with the progress of each, in their order.
    async fn with_progress(&self, batches: Vec<BatchRow>) -> Result<Vec<BatchRecord>, StoreError> {
        let ids: Vec<String> = batches.iter().map(|batch| batch.id.clone()).collect();
        let progress: Vec<ProgressRow> = sqlx::query_as(
            "SELECT batch_id, state, count(*) AS jobs, min(started_at) AS started_at, \
             max(finished_at) AS finished_at FROM jobs \
             WHERE batch_id = ANY($1) GROUP BY batch_id, state",
        )
        .bind(ids)
        .fetch_all(&self.reads)
        .await?;
        rows::batches(batches, &progress)
    }
}

/// Queues the jobs of a batch, or says why not all of them may be. Their meshes stay until the transaction ends.
async fn insert(
    id: BatchId,
    batch: &NewBatch,
    connection: &mut PgConnection,
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
    // One after the other, so that each counts those before it. Single jobs wait in this line only where little
    // room is left: those that come at the same moment may come on top.
    sqlx::query("SELECT pg_advisory_xact_lock($1)")
        .bind(COUNTING)
        .execute(&mut *connection)
        .await?;
    let (queued, own): (i64, i64) = sqlx::query_as(
        "SELECT (SELECT count(*) FROM jobs WHERE state = 'queued'), \
         (SELECT count(*) FROM jobs WHERE state = 'queued' \
          AND priority IN ('interactive', 'batch') AND owner = $1)",
    )
    .bind(owner.as_str())
    .fetch_one(&mut *connection)
    .await?;
    if queued + wanted > i64::from(*capacity) {
        return Ok(Some(Refusal::QueueFull));
    }
    if share.is_some_and(|share| own + wanted > i64::from(share)) {
        return Ok(Some(Refusal::ShareUsed));
    }
    let meshes: HashSet<&str> = jobs.iter().map(|job| job.mesh_id.as_str()).collect();
    let meshes: Vec<&str> = meshes.into_iter().collect();
    let known = sqlx::query(
        "SELECT 1 FROM meshes WHERE owner = $1 AND id = ANY($2) ORDER BY id FOR KEY SHARE",
    )
    .bind(owner.as_str())
    .bind(&meshes)
    .execute(&mut *connection)
    .await?;
    if known.rows_affected() != meshes.len() as u64 {
        return Ok(Some(Refusal::UnknownMesh));
    }
    let created_at: i64 = sqlx::query_scalar(
        "INSERT INTO batches (id, owner, label, jobs, created_at) \
         VALUES ($1, $2, $3, $4, now_us()) RETURNING created_at",
    )
    .bind(id.to_string())
    .bind(owner.as_str())
    .bind(label.as_deref())
    .bind(wanted)
    .fetch_one(&mut *connection)
    .await?;
    let ids: Vec<String> = jobs.iter().map(|_| JobId::new().to_string()).collect();
    let mesh_ids: Vec<&str> = jobs.iter().map(|job| job.mesh_id.as_str()).collect();
    let priorities: Vec<&str> = jobs.iter().map(|job| job.priority.name()).collect();
    let labels: Vec<Option<&str>> = jobs.iter().map(|job| job.label.as_deref()).collect();
    let requests: Vec<&str> = jobs.iter().map(|job| job.request.as_str()).collect();
    sqlx::query(
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
    .bind(requests)
    .execute(&mut *connection)
    .await?;
    if let Some(submission) = submission
        && !submissions::insert(submission, owner, id.into(), connection).await?
    {
        return Ok(Some(Refusal::Submitted));
    }
    sqlx::query(
        "UPDATE meshes SET used_at = now_us() \
         WHERE owner = $1 AND id = ANY($2) AND used_at < now_us() - 1000000",
    )
    .bind(owner.as_str())
    .bind(meshes)
    .execute(connection)
    .await?;
    Ok(None)
}
