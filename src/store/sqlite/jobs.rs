//! Jobs as clients ask for them: submitted, read and cancelled.

use async_trait::async_trait;
use sqlx::FromRow;

use super::connections::Transaction;
use super::{Sqlite, now, submissions};
use crate::store::common::jobs::JobEngine;
use crate::store::common::rows::{self, JobRow, job_columns, job_columns_with_mesh};
use crate::store::{NewJob, Owner, Refusal, StoreError};
use crate::wire::{JobId, JobRecord, MeshId};

/// Ends, at `$2`, the jobs that wait among those that a WHERE behind it names, and marks those that run.
macro_rules! cancel {
    () => {
        "UPDATE jobs SET cancel_requested = 1, revision = revision + 1, \
         finished_at = CASE state WHEN 'queued' THEN max($2, created_at) END, \
         state = CASE state WHEN 'queued' THEN 'cancelled' ELSE state END "
    };
}
pub(super) use cancel;

/// A job with its result as it is stored.
#[derive(FromRow)]
struct JobRowWithResult {
    #[sqlx(flatten)]
    job: JobRow,
    result: Option<String>,
}

#[async_trait]
impl JobEngine for Sqlite {
    const COUNT_QUEUED: &'static str = "SELECT jobs FROM job_counts WHERE state = 'queued'";
    const COUNT_UNFINISHED: &'static str = "SELECT \
        (SELECT jobs FROM job_counts WHERE state = 'queued'), \
        (SELECT jobs FROM job_counts WHERE state = 'running'), \
        (SELECT min(id) FROM jobs WHERE state = 'queued')";
    const COUNT_ENDED: &'static str =
        "SELECT state, jobs FROM job_counts WHERE state NOT IN ('queued', 'running')";

    async fn insert_job(
        &self,
        mesh: &MeshId,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        let mut transaction = self.writer.begin().await?;
        let outcome = insert(job, mesh, &mut transaction).await?;
        transaction.end(outcome.is_ok()).await?;
        Ok(outcome)
    }

    async fn job_with_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<Option<JobRecord>, StoreError> {
        let statement = sqlx::query(concat!(
            "SELECT ",
            job_columns_with_mesh!(),
            ", result FROM jobs WHERE id = $1 AND owner = $2"
        ))
        .bind(id.to_string())
        .bind(owner.as_str());
        let row = self.readers.read(statement).await?.first()?;
        let Some(JobRowWithResult { job, result }) = row else {
            return Ok(None);
        };
        let mut job = JobRecord::try_from(job)?;
        if let Some(result) = result {
            job.result = Some(rows::result(result).await?);
        }
        Ok(Some(job))
    }

    async fn cancel_job(&self, owner: &Owner, id: JobId) -> Result<Option<JobRow>, StoreError> {
        let cancel = || async {
            let statement = sqlx::query(concat!(
                cancel!(),
                "WHERE id = $1 AND owner = $3 AND state IN ('queued', 'running') RETURNING ",
                job_columns!()
            ))
            .bind(id.to_string())
            .bind(now())
            .bind(owner.as_str());
            self.writer.run(statement).await?.first()
        };
        self.with_reserve(cancel).await
    }
}

/// Queues a job if there is such a mesh and room.
pub(super) async fn insert(
    job: &NewJob,
    mesh: &MeshId,
    transaction: &mut Transaction,
) -> Result<Result<JobRecord, Refusal>, StoreError> {
    let NewJob {
        owner,
        request,
        label,
        priority,
        capacity,
        owner_capacity,
        submission,
    } = job;
    let created_at = now();
    let statement = sqlx::query(concat!(
        "INSERT INTO jobs (id, owner, mesh_id, state, priority, created_at, label, request) \
         SELECT $1, $2, $3, 'queued', $4, $5, $6, $7 \
         WHERE EXISTS (SELECT 1 FROM meshes WHERE owner = $2 AND id = $3) \
         AND (SELECT jobs FROM job_counts WHERE state = 'queued') < $8 \
         AND ($9 IS NULL OR (SELECT count(*) FROM jobs WHERE state = 'queued' \
              AND priority IN ('interactive', 'batch') AND owner = $2) < $9) RETURNING ",
        job_columns!()
    ))
    .bind(JobId::new().to_string())
    .bind(owner.as_str())
    .bind(mesh.as_str())
    .bind(priority.name())
    .bind(created_at)
    .bind(label.as_deref())
    .bind(request.as_str())
    .bind(capacity)
    .bind(owner_capacity);
    let Some(row) = transaction.run(statement).await?.first::<JobRow>()? else {
        return refusal(job, mesh, transaction).await.map(Err);
    };
    let job = JobRecord::try_from(row)?;
    if let Some(submission) = submission
        && !submissions::insert(submission, owner, job.id, created_at, transaction).await?
    {
        return Ok(Err(Refusal::KeyInUse));
    }
    Ok(Ok(job))
}

/// Why a job was not queued.
async fn refusal(
    job: &NewJob,
    mesh: &MeshId,
    transaction: &mut Transaction,
) -> Result<Refusal, StoreError> {
    let statement = sqlx::query(
        "SELECT EXISTS (SELECT 1 FROM meshes WHERE owner = $1 AND id = $2), \
         (SELECT jobs FROM job_counts WHERE state = 'queued') < $3",
    )
    .bind(job.owner.as_str())
    .bind(mesh.as_str())
    .bind(job.capacity);
    let (has_mesh, has_room) = transaction.run(statement).await?.one()?;
    Ok(Refusal::of_job(has_mesh, has_room))
}
