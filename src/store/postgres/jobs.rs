//! Jobs as clients ask for them: submitted, read and cancelled.

use async_trait::async_trait;

use super::connections::{PATIENCE, Transaction, within};
use super::{PIECE_BYTES, Postgres, submissions};
use crate::store::common::jobs::JobEngine;
use crate::store::common::rows::{self, JobRow, job_columns};
use crate::store::{Jobs, NewJob, Owner, Refusal, StoreError, damaged};
use crate::wire::{JobId, JobRecord, MeshId};

/// The version of the settings of a job as this program writes them: raised when an earlier program could not
/// read them.
pub(super) const FORMAT: i64 = 1;

/// So far below a bound, counting without a lock cannot go past it: that many submissions are never under way at
/// the same moment.
const MARGIN: u32 = 512;

/// The lock of whoever counts the jobs that wait before it adds to them.
const COUNTING: i64 = 0x6772_6173_7064;

/// Ends the jobs that wait among those that a WHERE behind it names, and marks those that run.
macro_rules! cancel {
    () => {
        "UPDATE jobs SET cancel_requested = true, revision = revision + 1, \
         finished_at = CASE state WHEN 'queued' THEN greatest(now_us(), created_at) END, \
         state = CASE state WHEN 'queued' THEN 'cancelled' ELSE state END "
    };
}
pub(super) use cancel;

#[async_trait]
impl JobEngine for Postgres {
    const COUNT_QUEUED: &'static str = "SELECT count(*) FROM jobs WHERE state = 'queued'";
    // Counted together, so that the oldest is not looked for in the index of all jobs, behind those that have ended.
    const COUNT_UNFINISHED: &'static str = "SELECT queued.jobs, running.jobs, queued.oldest FROM \
        (SELECT count(*) AS jobs, min(id) AS oldest FROM jobs WHERE state = 'queued') AS queued, \
        (SELECT count(*) AS jobs FROM jobs WHERE state = 'running') AS running";
    const COUNT_ENDED: &'static str =
        "SELECT state, count(*) FROM jobs WHERE finished_at IS NOT NULL GROUP BY state";

    async fn insert_job(
        &self,
        mesh: &MeshId,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        within(PATIENCE, async {
            let mut transaction = self.writes.begin().await?;
            let outcome = insert(job, mesh, &mut transaction).await?;
            transaction.end(outcome.is_ok()).await?;
            Ok(outcome)
        })
        .await
    }

    async fn job_with_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<Option<JobRecord>, StoreError> {
        let Some(mut job) = self.job_without_result(owner, id).await? else {
            return Ok(None);
        };
        if job.state.is_final() {
            job.result = self.result(id).await?;
        }
        Ok(Some(job))
    }

    async fn cancel_job(&self, owner: &Owner, id: JobId) -> Result<Option<JobRow>, StoreError> {
        let statement = sqlx::query(concat!(
            cancel!(),
            "WHERE id = $1 AND owner = $2 AND state IN ('queued', 'running') RETURNING ",
            job_columns!()
        ));
        let statement = statement.bind(id.to_string()).bind(owner.as_str());
        self.writes.run(statement).await?.first()
    }
}

impl Postgres {
    /// Returns the result of a job, put together from its pieces.
    async fn result(
        &self,
        id: JobId,
    ) -> Result<Option<Box<serde_json::value::RawValue>>, StoreError> {
        let mut bytes: Vec<u8> = Vec::new();
        for number in 0_i64.. {
            let statement =
                sqlx::query("SELECT data FROM results WHERE job_id = $1 AND number = $2");
            let statement = statement.bind(id.to_string()).bind(number);
            let piece: Option<(Vec<u8>,)> = self.reads.run(statement).await?.first()?;
            let Some((piece,)) = piece else { break };
            let is_last = piece.len() < PIECE_BYTES;
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

/// Queues a job, exactly up to its bounds. The mesh stays until the transaction ends.
pub(super) async fn insert(
    job: &NewJob,
    mesh: &MeshId,
    transaction: &mut Transaction,
) -> Result<Result<JobRecord, Refusal>, StoreError> {
    match insert_below(job, mesh, MARGIN, transaction).await? {
        Err(Refusal::QueueFull | Refusal::OwnerQueueFull) => {}
        outcome => return Ok(outcome),
    }
    count_alone(transaction).await?;
    insert_below(job, mesh, 0, transaction).await
}

/// Lets nobody else count the jobs that wait until the transaction ends, so that each counts those before it.
pub(super) async fn count_alone(transaction: &mut Transaction) -> Result<(), StoreError> {
    let lock = sqlx::query("SELECT pg_advisory_xact_lock($1)");
    transaction.run(lock.bind(COUNTING)).await?;
    Ok(())
}

/// Queues a job if there is such a mesh and room, `margin` places of it left aside.
async fn insert_below(
    job: &NewJob,
    mesh: &MeshId,
    margin: u32,
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
    let bound = |capacity: u32| i64::from(capacity.saturating_sub(margin));
    let statement = sqlx::query(concat!(
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
    .bind(bound(*capacity))
    .bind(owner_capacity.map(bound));
    let Some(row) = transaction.run(statement).await?.first::<JobRow>()? else {
        let refusal = refusal(owner, mesh, bound(*capacity), transaction).await?;
        return Ok(Err(refusal));
    };
    let job = JobRecord::try_from(row)?;
    if let Some(submission) = submission
        && !submissions::insert(submission, owner, job.id, transaction).await?
    {
        return Ok(Err(Refusal::KeyInUse));
    }
    // Once a second at most, or all jobs on a mesh would wait for each other.
    let use_mesh = sqlx::query(
        "UPDATE meshes SET used_at = now_us() \
         WHERE owner = $1 AND id = $2 AND used_at < now_us() - 1000000",
    );
    let use_mesh = use_mesh.bind(owner.as_str()).bind(mesh.as_str());
    transaction.run(use_mesh).await?;
    Ok(Ok(job))
}

/// Why a job was not queued.
async fn refusal(
    owner: &Owner,
    mesh: &MeshId,
    bound: i64,
    transaction: &mut Transaction,
) -> Result<Refusal, StoreError> {
    let statement = sqlx::query(
        "SELECT EXISTS (SELECT 1 FROM meshes WHERE owner = $1 AND id = $2), \
         (SELECT count(*) FROM (SELECT 1 FROM jobs WHERE state = 'queued' LIMIT $3) AS queued) < $3",
    )
    .bind(owner.as_str())
    .bind(mesh.as_str())
    .bind(bound);
    let (has_mesh, has_room) = transaction.run(statement).await?.one()?;
    Ok(Refusal::of_job(has_mesh, has_room))
}
