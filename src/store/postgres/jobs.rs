//! Jobs as clients ask for them: submit, read, list, cancel, forget.

use async_trait::async_trait;
use sqlx::postgres::{PgConnection, PgRow};
use sqlx::{FromRow, QueryBuilder, Row};

use super::connections::{PATIENCE, within};
use super::{Postgres, submissions};
use crate::store::rows::{self, JobRow, job_columns, job_columns_with_mesh};
use crate::store::{
    JobFilter, Jobs, MAX_PAGE, NewJob, Owner, Refusal, StoreError, Unfinished, cursor, damaged,
};
use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId};

/// The version of the settings of a job as this program writes them: raised when an earlier program could not
/// read them.
pub(super) const FORMAT: i64 = 1;

/// So far below a bound, counting without a lock cannot go past it: that many submissions are never under way at
/// the same moment.
pub(super) const MARGIN: u32 = 512;

/// The lock of those who count what waits before they add to it.
pub(super) const COUNTING: i64 = 0x6772_6173_7064;

/// Ends the jobs that wait among those that a WHERE behind it names, and marks those that run.
macro_rules! cancel {
    () => {
        "UPDATE jobs SET cancel_requested = true, revision = revision + 1, \
         finished_at = CASE state WHEN 'queued' THEN greatest(now_us(), created_at) END, \
         state = CASE state WHEN 'queued' THEN 'cancelled' ELSE state END "
    };
}
pub(super) use cancel;

/// Queues a job if there is such a mesh and room, `margin` places of it left aside. The mesh stays until the
/// transaction ends.
pub(super) async fn insert(
    job: &NewJob,
    mesh: &MeshId,
    margin: u32,
    connection: &mut PgConnection,
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
    let room = i64::from(capacity.saturating_sub(margin));
    let share_room = share.map(|share| i64::from(share.saturating_sub(margin)));
    let row: Option<JobRow> = sqlx::query_as(concat!(
        "INSERT INTO jobs (id, owner, mesh_id, state, priority, format, created_at, label, request) \
         SELECT $1, $2, $3, 'queued', $4, $5, now_us(), $6, $7 \
         FROM (SELECT 1 FROM meshes WHERE owner = $2 AND id = $3 FOR KEY SHARE) AS mesh \
         WHERE (SELECT count(*) FROM (SELECT 1 FROM jobs WHERE state = 'queued' LIMIT $8) AS queued) < $8 \
         AND ($9::bigint IS NULL OR (SELECT count(*) FROM (SELECT 1 FROM jobs WHERE state = 'queued' \
              AND priority IN ('interactive', 'batch') AND owner = $2 LIMIT $9) AS queued) < $9) RETURNING ",
        job_columns!()
    ))
    .bind(JobId::new().to_string())
    .bind(owner.as_str())
    .bind(mesh.as_str())
    .bind(priority.name())
    .bind(FORMAT)
    .bind(label.as_deref())
    .bind(request.as_str())
    .bind(room)
    .bind(share_room)
    .fetch_optional(&mut *connection)
    .await?;
    let Some(row) = row else {
        return refusal(job, mesh, room, connection).await.map(Err);
    };
    let job = JobRecord::try_from(row)?;
    if let Some(submission) = submission
        && !submissions::insert(submission, owner, job.id, connection).await?
    {
        return Ok(Err(Refusal::Submitted));
    }
    // Once a second at most, or all jobs on a mesh would wait for each other.
    sqlx::query(
        "UPDATE meshes SET used_at = now_us() WHERE owner = $1 AND id = $2 AND used_at < now_us() - 1000000",
    )
    .bind(owner.as_str())
    .bind(mesh.as_str())
    .execute(connection)
    .await?;
    Ok(Ok(job))
}

/// Queues a job, exactly up to its bounds.
pub(super) async fn insert_exactly(
    job: &NewJob,
    mesh: &MeshId,
    connection: &mut PgConnection,
) -> Result<Result<JobRecord, Refusal>, StoreError> {
    match insert(job, mesh, MARGIN, connection).await? {
        Err(Refusal::QueueFull | Refusal::ShareUsed) => {}
        outcome => return Ok(outcome),
    }
    // One after the other, so that each counts those before it.
    sqlx::query("SELECT pg_advisory_xact_lock($1)")
        .bind(COUNTING)
        .execute(&mut *connection)
        .await?;
    insert(job, mesh, 0, connection).await
}

/// Why a job was not queued.
async fn refusal(
    job: &NewJob,
    mesh: &MeshId,
    room: i64,
    connection: &mut PgConnection,
) -> Result<Refusal, StoreError> {
    let (known, has_room): (bool, bool) = sqlx::query_as(
        "SELECT EXISTS (SELECT 1 FROM meshes WHERE owner = $1 AND id = $2), \
         (SELECT count(*) FROM (SELECT 1 FROM jobs WHERE state = 'queued' LIMIT $3) AS queued) < $3",
    )
    .bind(job.owner.as_str())
    .bind(mesh.as_str())
    .bind(room)
    .fetch_one(connection)
    .await?;
    Ok(match (known, has_room) {
        (false, _) => Refusal::UnknownMesh,
        (true, false) => Refusal::QueueFull,
        (true, true) => Refusal::ShareUsed,
    })
}

#[async_trait]
impl Jobs for Postgres {
    async fn submit(
        &self,
        mesh: &MeshId,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        within(PATIENCE, async {
            let mut transaction = self.writes.begin().await?;
            let outcome = insert_exactly(job, mesh, &mut transaction).await?;
            match outcome {
                Ok(_) => transaction.commit().await?,
                Err(_) => transaction.rollback().await?,
            }
            Ok(outcome)
        })
        .await
    }

    async fn queued(&self) -> Result<u32, StoreError> {
        let queued: i64 = sqlx::query_scalar("SELECT count(*) FROM jobs WHERE state = 'queued'")
            .fetch_one(&self.reads)
            .await?;
        u32::try_from(queued).map_err(damaged)
    }

    async fn unfinished_jobs(&self) -> Result<Unfinished, StoreError> {
        // Counted together, so that the oldest is not looked for in the index of all jobs, behind those that have ended.
        let row = sqlx::query_as(
            "SELECT queued.jobs, running.jobs, queued.oldest FROM \
             (SELECT count(*) AS jobs, min(id) AS oldest FROM jobs WHERE state = 'queued') AS queued, \
             (SELECT count(*) AS jobs FROM jobs WHERE state = 'running') AS running",
        )
        .fetch_one(&self.reads)
        .await?;
        rows::unfinished(row)
    }

    async fn ended_jobs(&self) -> Result<Vec<(JobState, u64)>, StoreError> {
        let counts: Vec<(String, i64)> = sqlx::query_as(
            "SELECT state, count(*) FROM jobs WHERE finished_at IS NOT NULL GROUP BY state",
        )
        .fetch_all(&self.reads)
        .await?;
        counts.into_iter().map(rows::count_of_state).collect()
    }

    async fn job(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let Some(mut job) = self.job_without_result(owner, id).await? else {
            return Ok(None);
        };
        if job.state.is_final() {
            job.result = self.result(id).await?;
        }
        Ok(Some(job))
    }

    async fn job_without_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<Option<JobRecord>, StoreError> {
        let row: Option<JobRow> = sqlx::query_as(concat!(
            "SELECT ",
            job_columns_with_mesh!(),
            " FROM jobs WHERE id = $1 AND owner = $2"
        ))
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_optional(&self.reads)
        .await?;
        row.map(TryInto::try_into).transpose()
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
        let mut query = QueryBuilder::new(concat!(
            "SELECT ",
            job_columns!(),
            " FROM jobs WHERE owner = "
        ));
        query.push_bind(owner.as_str());
        if let Some(state) = state {
            query.push(" AND state = ").push_bind(state.name());
        }
        // No text here may have a zero byte, and none that is an id has.
        let plain = |id: &String| id.replace('\0', " ");
        if let Some(mesh_id) = mesh_id {
            query.push(" AND mesh_id = ").push_bind(plain(mesh_id));
        }
        if let Some(batch_id) = batch_id {
            query.push(" AND batch_id = ").push_bind(plain(batch_id));
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
        let rows = query.build().fetch_all(&self.reads).await?;
        let record = |row: &PgRow| JobRow::from_row(row)?.try_into();
        let jobs: Vec<JobRecord> = rows.iter().map(record).collect::<Result<_, StoreError>>()?;
        let (jobs, next_cursor) = cursor::page(LIST, jobs, limit, |job| job.id.to_string());
        Ok(Some(JobPage { jobs, next_cursor }))
    }

    async fn revisions(&self, jobs: &[JobId]) -> Result<Vec<(JobId, u64)>, StoreError> {
        let ids: Vec<String> = jobs.iter().map(JobId::to_string).collect();
        let rows = sqlx::query("SELECT id, revision FROM jobs WHERE id = ANY($1)")
            .bind(ids)
            .fetch_all(&self.reads)
            .await?;
        rows.iter()
            .map(|row| {
                let revision: i64 = row.try_get("revision")?;
                Ok((rows::job_id(row.try_get("id")?)?, revision as u64))
            })
            .collect()
    }

    async fn cancel(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let row: Option<JobRow> = sqlx::query_as(concat!(
            cancel!(),
            "WHERE id = $1 AND owner = $2 AND state IN ('queued', 'running') RETURNING ",
            job_columns!()
        ))
        .bind(id.to_string())
        .bind(owner.as_str())
        .fetch_optional(&self.writes)
        .await?;
        row.map(TryInto::try_into).transpose()
    }

    async fn delete_job(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError> {
        let deleted = sqlx::query("DELETE FROM jobs WHERE id = $1 AND owner = $2")
            .bind(id.to_string())
            .bind(owner.as_str())
            .execute(&self.writes)
            .await?;
        Ok(deleted.rows_affected() > 0)
    }
}

impl Postgres {
    /// The result of a job, put together from its pieces.
    async fn result(
        &self,
        id: JobId,
    ) -> Result<Option<Box<serde_json::value::RawValue>>, StoreError> {
        let mut bytes: Vec<u8> = Vec::new();
        for number in 0_i64.. {
            let piece: Option<Vec<u8>> =
                sqlx::query_scalar("SELECT data FROM results WHERE job_id = $1 AND number = $2")
                    .bind(id.to_string())
                    .bind(number)
                    .fetch_optional(&self.reads)
                    .await?;
            let Some(piece) = piece else { break };
            let is_last = piece.len() < super::PIECE_BYTES;
            match bytes.is_empty() {
                true => bytes = piece,
                false => bytes.extend(piece),
            }
            if is_last {
                break;
            }
        }
        if bytes.is_empty() {
            return Ok(None);
        }
        let text = String::from_utf8(bytes).map_err(damaged)?;
        rows::result(text).await.map(Some)
    }
}
