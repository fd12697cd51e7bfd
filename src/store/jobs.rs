//! Jobs as clients ask for them: submit, read, list, cancel, forget.

use serde_json::value::RawValue;
use sqlx::sqlite::{SqliteConnection, SqliteRow};
use sqlx::{QueryBuilder, Row};

use super::submissions::Submission;
use super::{MAX_PAGE, Owner, Store, StoreError, cursor, damaged, now, timestamp};
use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId, Priority};

/// Results of more bytes are read off the async threads.
const LONG_RESULT: usize = 64 * 1024;

/// A job to be queued.
#[derive(Debug)]
pub struct NewJob {
    pub owner: Owner,
    /// The effective settings, as JSON.
    pub request: String,
    pub label: Option<String>,
    pub priority: Priority,
    /// Most jobs that may be queued, this one among them.
    pub capacity: u32,
    /// As many of them may be of this owner.
    pub share: Option<u32>,
    /// Under which key it is submitted, and only once.
    pub submission: Option<Submission>,
}

/// Why a job was not queued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    UnknownMesh,
    QueueFull,
    /// As many jobs of this owner wait as may.
    ShareUsed,
    /// The meshes of this owner take as much room as they may.
    RoomUsed,
    /// Another submission under the same key was faster.
    Submitted,
}

/// Which jobs of an owner to list; `None` means any.
#[derive(Debug, Clone, Default)]
pub struct JobFilter {
    pub owner: Owner,
    pub state: Option<JobState>,
    /// As clients write it; what cannot be an id is on no job.
    pub mesh_id: Option<String>,
}

/// The jobs in the store.
#[derive(Debug, Clone)]
pub struct Stock {
    /// How many are in each state.
    pub jobs: Vec<(JobState, u64)>,
    /// The one that waits longest.
    pub oldest_queued: Option<JobId>,
}

/// Every column of a [`JobRecord`] but the result, which may be long.
macro_rules! columns {
    () => {
        "id, mesh_id, state, priority, attempt, revision, created_at, started_at, finished_at, \
         label, request, progress, problem"
    };
}

/// Ends, at ?2, the jobs that wait among those that a WHERE behind it names, and marks those that run.
macro_rules! cancel {
    () => {
        "UPDATE jobs SET cancel_requested = 1, revision = revision + 1, \
         finished_at = CASE state WHEN 'queued' THEN max(?2, created_at) END, \
         state = CASE state WHEN 'queued' THEN 'cancelled' ELSE state END "
    };
}
pub(super) use cancel;

/// The report of the job's mesh, as one more column.
macro_rules! mesh_report {
    () => {
        ", (SELECT report FROM meshes WHERE meshes.owner = jobs.owner AND meshes.id = jobs.mesh_id) \
         AS mesh_report"
    };
}

impl NewJob {
    /// Queues the job if there is such a mesh and room.
    pub(super) async fn insert(
        &self,
        mesh: &MeshId,
        transaction: &mut SqliteConnection,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        let Self {
            owner,
            request,
            label,
            priority,
            capacity,
            share,
            submission,
        } = self;
        let created_at = now();
        let rows = sqlx::query(concat!(
            "INSERT INTO jobs (id, owner, mesh_id, state, priority, created_at, label, request) \
             SELECT ?1, ?2, ?3, 'queued', ?4, ?5, ?6, ?7 \
             WHERE EXISTS (SELECT 1 FROM meshes WHERE owner = ?2 AND id = ?3) \
             AND (SELECT jobs FROM stock WHERE state = 'queued') < ?8 \
             AND (?9 IS NULL OR (SELECT count(*) FROM jobs WHERE state = 'queued' \
                  AND priority IN ('interactive', 'batch') AND owner = ?2) < ?9) RETURNING ",
            columns!()
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
            return self.refusal(mesh, transaction).await.map(Err);
        };
        let job = record(row)?;
        if let Some(submission) = submission
            && !submission
                .insert(owner, job.id, created_at, transaction)
                .await?
        {
            return Ok(Err(Refusal::Submitted));
        }
        Ok(Ok(job))
    }

    /// Why it was not queued.
    async fn refusal(
        &self,
        mesh: &MeshId,
        transaction: &mut SqliteConnection,
    ) -> Result<Refusal, StoreError> {
        let (known, queued): (bool, u32) = sqlx::query_as(
            "SELECT EXISTS (SELECT 1 FROM meshes WHERE owner = ?1 AND id = ?2), \
             (SELECT jobs FROM stock WHERE state = 'queued')",
        )
        .bind(self.owner.as_str())
        .bind(mesh.as_str())
        .fetch_one(transaction)
        .await?;
        Ok(match (known, queued >= self.capacity) {
            (false, _) => Refusal::UnknownMesh,
            (true, true) => Refusal::QueueFull,
            (true, false) => Refusal::ShareUsed,
        })
    }
}

impl Store {
    /// Queues a job; it is on stable storage once this returns it. Must be run to its end.
    pub async fn submit(
        &self,
        mesh: &MeshId,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        let mut transaction = self.writer.begin().await?;
        let outcome = job.insert(mesh, &mut transaction).await?;
        match outcome {
            Ok(_) => transaction.commit().await?,
            Err(_) => transaction.rollback().await?,
        }
        Ok(outcome)
    }

    /// How many jobs wait.
    pub async fn queued(&self) -> Result<u32, StoreError> {
        Ok(
            sqlx::query_scalar("SELECT jobs FROM stock WHERE state = 'queued'")
                .fetch_one(&self.readers)
                .await?,
        )
    }

    /// How many jobs are in each state, and the one that waits longest. Costs time proportional to those
    /// that wait.
    pub async fn stock(&self) -> Result<Stock, StoreError> {
        let counts: Vec<(String, i64)> = sqlx::query_as("SELECT state, jobs FROM stock")
            .fetch_all(&self.readers)
            .await?;
        let oldest: Option<String> =
            sqlx::query_scalar("SELECT min(id) FROM jobs WHERE state = 'queued'")
                .fetch_one(&self.readers)
                .await?;
        let count = |(state, jobs): (String, i64)| {
            let state = JobState::named(&state).ok_or_else(|| damaged("job state"))?;
            Ok((state, jobs as u64))
        };
        let oldest = oldest.map(|id| JobId::parse(&id).ok_or_else(|| damaged("job id")));
        Ok(Stock {
            jobs: counts
                .into_iter()
                .map(count)
                .collect::<Result<_, StoreError>>()?,
            oldest_queued: oldest.transpose()?,
        })
    }

    /// A job of an owner with its result.
    pub async fn job(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let row = sqlx::query(concat!(
            "SELECT ",
            columns!(),
            mesh_report!(),
            ", result FROM jobs WHERE id = ?1 AND owner = ?2"
        ))
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_optional(&self.readers)
        .await?;
        let Some(row) = row else {
            return Ok(None);
        };
        let mut job = with_mesh(&row)?;
        if let Some(result) = row.try_get("result")? {
            job.result = Some(raw(result).await?);
        }
        Ok(Some(job))
    }

    /// A job of an owner without its result.
    pub async fn job_without_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<Option<JobRecord>, StoreError> {
        let row = sqlx::query(concat!(
            "SELECT ",
            columns!(),
            mesh_report!(),
            " FROM jobs WHERE id = ?1 AND owner = ?2"
        ))
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_optional(&self.readers)
        .await?;
        row.as_ref().map(with_mesh).transpose()
    }

    /// At most `limit` jobs without their results, newest first, from where `cursor` ended.
    /// `None` when the cursor is not one of this list.
    pub async fn jobs(
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
        } = filter;
        let limit = limit.clamp(1, MAX_PAGE) as usize;
        // Built rather than fixed with `OR ?1 IS NULL`, which would keep SQLite off the indices.
        let mut query =
            QueryBuilder::new(concat!("SELECT ", columns!(), " FROM jobs WHERE owner = "));
        query.push_bind(owner.as_str());
        if let Some(state) = state {
            query.push(" AND state = ").push_bind(state.name());
        }
        if let Some(mesh_id) = mesh_id {
            query.push(" AND mesh_id = ").push_bind(mesh_id.clone());
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
        let mut rows = query.build().fetch_all(&self.readers).await?;
        let more = rows.len() > limit;
        rows.truncate(limit);
        let jobs = rows.iter().map(record).collect::<Result<Vec<_>, _>>()?;
        let next_cursor = jobs
            .last()
            .filter(|_| more)
            .map(|last| cursor::encode(LIST, &last.id.to_string()));
        Ok(Some(JobPage { jobs, next_cursor }))
    }

    /// Ends a queued job, or marks a running one so that it ends as cancelled whatever becomes
    /// of its worker. `None` when there is no such job or it has ended.
    pub async fn cancel(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let statement = sqlx::query(concat!(
            cancel!(),
            "WHERE id = ?1 AND owner = ?3 AND state IN ('queued', 'running') RETURNING ",
            columns!()
        ))
        .bind(id.to_string())
        .bind(now())
        .bind(owner.as_str());
        let rows = self.write_returning(statement).await?;
        rows.first().map(record).transpose()
    }

    /// Forgets a job, whatever its state. Says whether there was one.
    pub async fn delete_job(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError> {
        let deleted = sqlx::query("DELETE FROM jobs WHERE id = ?1 AND owner = ?2")
            .bind(id.to_string())
            .bind(owner.as_str())
            .execute(&self.writer)
            .await?;
        Ok(deleted.rows_affected() > 0)
    }
}

/// A record with the report of its mesh, without its result.
fn with_mesh(row: &SqliteRow) -> Result<JobRecord, StoreError> {
    let report: Option<String> = row.try_get("mesh_report")?;
    let report = report.map(RawValue::from_string).transpose();
    Ok(JobRecord {
        mesh_report: report.map_err(damaged)?,
        ..record(row)?
    })
}

/// A record without its result.
pub(super) fn record(row: &SqliteRow) -> Result<JobRecord, StoreError> {
    let (id, state): (&str, &str) = (row.try_get("id")?, row.try_get("state")?);
    let priority: &str = row.try_get("priority")?;
    Ok(JobRecord {
        id: JobId::parse(id).ok_or_else(|| damaged("job id"))?,
        mesh_id: row.try_get("mesh_id")?,
        mesh_report: None,
        state: JobState::named(state).ok_or_else(|| damaged("job state"))?,
        priority: Priority::named(priority).ok_or_else(|| damaged("job priority"))?,
        label: row.try_get("label")?,
        request: RawValue::from_string(row.try_get("request")?).map_err(damaged)?,
        progress: parsed(row.try_get("progress")?)?,
        result: None,
        problem: parsed(row.try_get("problem")?)?,
        callback: None,
        attempt: row.try_get("attempt")?,
        revision: row.try_get::<i64, _>("revision")? as u64,
        created_at: timestamp(row.try_get("created_at")?)?,
        started_at: row
            .try_get::<Option<i64>, _>("started_at")?
            .map(timestamp)
            .transpose()?,
        finished_at: row
            .try_get::<Option<i64>, _>("finished_at")?
            .map(timestamp)
            .transpose()?,
    })
}

/// Checks a stored result, which takes long for a long one.
async fn raw(text: String) -> Result<Box<RawValue>, StoreError> {
    if text.len() <= LONG_RESULT {
        return RawValue::from_string(text).map_err(damaged);
    }
    let checked = tokio::task::spawn_blocking(|| RawValue::from_string(text));
    checked.await.map_err(damaged)?.map_err(damaged)
}

fn parsed<T: serde::de::DeserializeOwned>(text: Option<&str>) -> Result<Option<T>, StoreError> {
    text.map(serde_json::from_str).transpose().map_err(damaged)
}
