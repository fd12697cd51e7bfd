//! Jobs as clients ask for them: submit, read, list, cancel, forget.

use serde_json::value::RawValue;
use sqlx::sqlite::SqliteRow;
use sqlx::{QueryBuilder, Row};

use super::{MAX_PAGE, Statement, Store, StoreError, cursor, damaged, now, timestamp};
use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId};

/// Results of more bytes are read off the async threads.
const LONG_RESULT: usize = 64 * 1024;

/// A job to be queued.
#[derive(Debug)]
pub struct NewJob {
    /// The effective settings, as JSON.
    pub request: String,
    pub label: Option<String>,
    /// Most jobs that may be queued, this one among them.
    pub capacity: u32,
}

/// Why a job was not queued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    UnknownMesh,
    QueueFull,
}

/// Which jobs to list; `None` means any.
#[derive(Debug, Clone, Default)]
pub struct JobFilter {
    pub state: Option<JobState>,
    /// As clients write it; what cannot be an id is on no job.
    pub mesh_id: Option<String>,
}

/// The jobs in one state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stock {
    pub state: JobState,
    pub jobs: u64,
    pub oldest: JobId,
}

/// Every column of a [`JobRecord`] but the result, which may be long.
macro_rules! columns {
    () => {
        "id, mesh_id, state, attempt, revision, created_at, started_at, finished_at, label, \
         request, progress, problem"
    };
}

/// The report of the job's mesh, as one more column.
macro_rules! mesh_report {
    () => {
        ", (SELECT report FROM meshes WHERE meshes.id = jobs.mesh_id) AS mesh_report"
    };
}

impl NewJob {
    /// Queues the job if there is such a mesh and room; the row comes back if so.
    pub(super) fn insert(&self, mesh: &MeshId) -> Statement<'_> {
        sqlx::query(concat!(
            "INSERT INTO jobs (id, mesh_id, state, created_at, label, request) \
             SELECT ?1, ?2, 'queued', ?3, ?4, ?5 \
             WHERE EXISTS (SELECT 1 FROM meshes WHERE id = ?2) \
             AND (SELECT count(*) FROM jobs WHERE state = 'queued') < ?6 RETURNING ",
            columns!()
        ))
        .bind(JobId::new().to_string())
        .bind(mesh.to_string())
        .bind(now())
        .bind(self.label.as_deref())
        .bind(self.request.as_str())
        .bind(self.capacity)
    }
}

impl Store {
    /// Queues a job; it is on stable storage once this returns it.
    pub async fn submit(
        &self,
        mesh: &MeshId,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        let rows = self.write_returning(job.insert(mesh)).await?;
        Ok(match rows.first() {
            Some(row) => Ok(record(row)?),
            None if self.kept(mesh).await?.is_some() => Err(Refusal::QueueFull),
            None => Err(Refusal::UnknownMesh),
        })
    }

    /// How many jobs wait. Costs time proportional to their number, about 1 ms for 10,000.
    pub async fn queued(&self) -> Result<u32, StoreError> {
        Ok(
            sqlx::query_scalar("SELECT count(*) FROM jobs WHERE state = 'queued'")
                .fetch_one(&self.readers)
                .await?,
        )
    }

    /// The states that any job is in. Costs time proportional to the number of jobs, about 20 ms for
    /// 100,000.
    pub async fn stock(&self) -> Result<Vec<Stock>, StoreError> {
        let rows =
            sqlx::query("SELECT state, count(*) AS jobs, min(id) AS id FROM jobs GROUP BY state")
                .fetch_all(&self.readers)
                .await?;
        let stock = |row: &SqliteRow| {
            let (id, state): (&str, &str) = (row.try_get("id")?, row.try_get("state")?);
            Ok(Stock {
                state: JobState::named(state).ok_or_else(|| damaged("job state"))?,
                jobs: row.try_get::<i64, _>("jobs")? as u64,
                oldest: JobId::parse(id).ok_or_else(|| damaged("job id"))?,
            })
        };
        rows.iter().map(stock).collect()
    }

    /// A job with its result.
    pub async fn job(&self, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let row = sqlx::query(concat!(
            "SELECT ",
            columns!(),
            mesh_report!(),
            ", result FROM jobs WHERE id = ?1"
        ))
        .bind(id.to_string())
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

    /// A job without its result.
    pub async fn job_without_result(&self, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let row = sqlx::query(concat!(
            "SELECT ",
            columns!(),
            mesh_report!(),
            " FROM jobs WHERE id = ?1"
        ))
        .bind(id.to_string())
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
        let JobFilter { state, mesh_id } = filter;
        let limit = limit.clamp(1, MAX_PAGE) as usize;
        // Built rather than fixed with `OR ?1 IS NULL`, which would keep SQLite off the indices.
        let mut query = QueryBuilder::new(concat!("SELECT ", columns!(), " FROM jobs WHERE TRUE"));
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
    pub async fn cancel(&self, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let statement = sqlx::query(concat!(
            "UPDATE jobs SET cancel_requested = 1, revision = revision + 1, \
             finished_at = CASE state WHEN 'queued' THEN ?2 END, \
             state = CASE state WHEN 'queued' THEN 'cancelled' ELSE state END \
             WHERE id = ?1 AND state IN ('queued', 'running') RETURNING ",
            columns!()
        ))
        .bind(id.to_string())
        .bind(now());
        let rows = self.write_returning(statement).await?;
        rows.first().map(record).transpose()
    }

    /// Forgets a job, whatever its state. Says whether there was one.
    pub async fn delete_job(&self, id: JobId) -> Result<bool, StoreError> {
        let deleted = sqlx::query("DELETE FROM jobs WHERE id = ?1")
            .bind(id.to_string())
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
    Ok(JobRecord {
        id: JobId::parse(id).ok_or_else(|| damaged("job id"))?,
        mesh_id: row.try_get("mesh_id")?,
        mesh_report: None,
        state: JobState::named(state).ok_or_else(|| damaged("job state"))?,
        label: row.try_get("label")?,
        request: RawValue::from_string(row.try_get("request")?).map_err(damaged)?,
        progress: parsed(row.try_get("progress")?)?,
        result: None,
        problem: parsed(row.try_get("problem")?)?,
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
