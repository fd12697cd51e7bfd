//! Jobs as clients ask for them: submit, read, list, cancel, forget.

use async_trait::async_trait;
use sqlx::sqlite::{SqliteConnection, SqliteRow};
use sqlx::{FromRow, QueryBuilder, Row};

use super::{Sqlite, now, submissions};
use crate::store::rows::{self, JobRow, job_columns, job_columns_with_mesh};
use crate::store::{
    JobFilter, Jobs, MAX_PAGE, NewJob, Owner, Refusal, StoreError, Unfinished, cursor,
};
use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId};

/// Ends, at ?2, the jobs that wait among those that a WHERE behind it names, and marks those that run.
macro_rules! cancel {
    () => {
        "UPDATE jobs SET cancel_requested = 1, revision = revision + 1, \
         finished_at = CASE state WHEN 'queued' THEN max(?2, created_at) END, \
         state = CASE state WHEN 'queued' THEN 'cancelled' ELSE state END "
    };
}
pub(super) use cancel;

/// Queues a job if there is such a mesh and room.
pub(super) async fn insert(
    job: &NewJob,
    mesh: &MeshId,
    transaction: &mut SqliteConnection,
) -> Result<Result<JobRecord, Refusal>, StoreError> {
    let NewJob {
        owner,
        request,
        label,
        priority,
        capacity,
        share,
        submission,
    } = job;
    let created_at = now();
    let rows = sqlx::query(concat!(
        "INSERT INTO jobs (id, owner, mesh_id, state, priority, created_at, label, request) \
         SELECT ?1, ?2, ?3, 'queued', ?4, ?5, ?6, ?7 \
         WHERE EXISTS (SELECT 1 FROM meshes WHERE owner = ?2 AND id = ?3) \
         AND (SELECT jobs FROM stock WHERE state = 'queued') < ?8 \
         AND (?9 IS NULL OR (SELECT count(*) FROM jobs WHERE state = 'queued' \
              AND priority IN ('interactive', 'batch') AND owner = ?2) < ?9) RETURNING ",
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
    .bind(share)
    .fetch_all(&mut *transaction)
    .await?;
    let Some(row) = rows.first() else {
        return refusal(job, mesh, transaction).await.map(Err);
    };
    let job = record(row)?;
    if let Some(submission) = submission
        && !submissions::insert(submission, owner, job.id, created_at, transaction).await?
    {
        return Ok(Err(Refusal::Submitted));
    }
    Ok(Ok(job))
}

/// Why a job was not queued.
async fn refusal(
    job: &NewJob,
    mesh: &MeshId,
    transaction: &mut SqliteConnection,
) -> Result<Refusal, StoreError> {
    let (known, queued): (bool, u32) = sqlx::query_as(
        "SELECT EXISTS (SELECT 1 FROM meshes WHERE owner = ?1 AND id = ?2), \
         (SELECT jobs FROM stock WHERE state = 'queued')",
    )
    .bind(job.owner.as_str())
    .bind(mesh.as_str())
    .fetch_one(transaction)
    .await?;
    Ok(match (known, queued >= job.capacity) {
        (false, _) => Refusal::UnknownMesh,
        (true, true) => Refusal::QueueFull,
        (true, false) => Refusal::ShareUsed,
    })
}

#[async_trait]
impl Jobs for Sqlite {
    async fn submit(
        &self,
        mesh: &MeshId,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        let mut transaction = self.writer.begin().await?;
        let outcome = insert(job, mesh, &mut transaction).await?;
        match outcome {
            Ok(_) => transaction.commit().await?,
            Err(_) => transaction.rollback().await?,
        }
        Ok(outcome)
    }

    async fn queued(&self) -> Result<u32, StoreError> {
        Ok(
            sqlx::query_scalar("SELECT jobs FROM stock WHERE state = 'queued'")
                .fetch_one(&self.readers)
                .await?,
        )
    }

    async fn unfinished_jobs(&self) -> Result<Unfinished, StoreError> {
        let row = sqlx::query_as(
            "SELECT (SELECT jobs FROM stock WHERE state = 'queued'), \
             (SELECT jobs FROM stock WHERE state = 'running'), \
             (SELECT min(id) FROM jobs WHERE state = 'queued')",
        )
        .fetch_one(&self.readers)
        .await?;
        rows::unfinished(row)
    }

    async fn ended_jobs(&self) -> Result<Vec<(JobState, u64)>, StoreError> {
        let counts: Vec<(String, i64)> = sqlx::query_as(
            "SELECT state, jobs FROM stock WHERE state NOT IN ('queued', 'running')",
        )
        .fetch_all(&self.readers)
        .await?;
        counts.into_iter().map(rows::count_of_state).collect()
    }

    async fn job(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let row = sqlx::query(concat!(
            "SELECT ",
            job_columns_with_mesh!(),
            ", result FROM jobs WHERE id = ?1 AND owner = ?2"
        ))
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_optional(&self.readers)
        .await?;
        let Some(row) = row else {
            return Ok(None);
        };
        let mut job = record(&row)?;
        if let Some(result) = row.try_get("result")? {
            job.result = Some(rows::result(result).await?);
        }
        Ok(Some(job))
    }

    async fn job_without_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<Option<JobRecord>, StoreError> {
        let row = sqlx::query(concat!(
            "SELECT ",
            job_columns_with_mesh!(),
            " FROM jobs WHERE id = ?1 AND owner = ?2"
        ))
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_optional(&self.readers)
        .await?;
        row.as_ref().map(record).transpose()
    }

    async fn jobs(
        &self,
        filter: &JobFilter,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<JobPage>, StoreError> {
        const LIST: &str = "jobs";
        let JobFilter {
            owner,
            state,
            mesh_id,
            batch_id,
        } = filter;
        let limit = limit.clamp(1, MAX_PAGE) as usize;
        // Built rather than fixed with `OR ?1 IS NULL`, which would keep SQLite off the indices.
        let mut query = QueryBuilder::new(concat!(
            "SELECT ",
            job_columns!(),
            " FROM jobs WHERE owner = "
        ));
        query.push_bind(owner.as_str());
        if let Some(state) = state {
            query.push(" AND state = ").push_bind(state.name());
        }
        if let Some(mesh_id) = mesh_id {
            query.push(" AND mesh_id = ").push_bind(mesh_id.clone());
        }
        if let Some(batch_id) = batch_id {
            query.push(" AND batch_id = ").push_bind(batch_id.clone());
        }
        if let Some(cursor) = cursor {
            let Some(last) = cursor::decode(LIST, cursor).and_then(JobId::parse) else {
                return Ok(None);
            };
            query.push(" AND id < ").push_bind(last.to_string());
        }
        query
            .push(" ORDER BY id DESC LIMIT ")
            .push_bind(limit as i64 + 1);
        let rows = query.build().fetch_all(&self.readers).await?;
        let jobs = rows.iter().map(record).collect::<Result<Vec<_>, _>>()?;
        let (jobs, next_cursor) = cursor::page(LIST, jobs, limit, |job| job.id.to_string());
        Ok(Some(JobPage { jobs, next_cursor }))
    }

    async fn revisions(&self, jobs: &[JobId]) -> Result<Vec<(JobId, u64)>, StoreError> {
        let mut found = Vec::with_capacity(jobs.len());
        for job in jobs {
            let revision: Option<i64> =
                sqlx::query_scalar("SELECT revision FROM jobs WHERE id = ?1")
                    .bind(job.to_string())
                    .fetch_optional(&self.readers)
                    .await?;
            found.extend(revision.map(|revision| (*job, revision as u64)));
        }
        Ok(found)
    }

    async fn cancel(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let cancel = || async {
            let statement = sqlx::query(concat!(
                cancel!(),
                "WHERE id = ?1 AND owner = ?3 AND state IN ('queued', 'running') RETURNING ",
                job_columns!()
            ))
            .bind(id.to_string())
            .bind(now())
            .bind(owner.as_str());
            self.write_returning(statement).await
        };
        let rows = self.with_reserve(cancel).await?;
        rows.first().map(record).transpose()
    }

    async fn delete_job(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError> {
        let delete = || async {
            let deleted = sqlx::query("DELETE FROM jobs WHERE id = ?1 AND owner = ?2")
                .bind(id.to_string())
                .bind(owner.as_str())
                .execute(&self.writer)
                .await?;
            Ok(deleted.rows_affected() > 0)
        };
        self.with_reserve(delete).await
    }
}

/// A record without its result.
fn record(row: &SqliteRow) -> Result<JobRecord, StoreError> {
    JobRow::from_row(row)?.try_into()
}
