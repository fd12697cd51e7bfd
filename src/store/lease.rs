//! Jobs as workers hold them: claim, finish, give back, recover.
//!
//! Whoever claims a job gets a lease with a token of its own. Every later write names it and
//! changes nothing once the job is in other hands, was ended or was forgotten.
//!
//! The clock of the machine may be set back at any moment: no time is written that comes before the
//! one it follows.

use serde_json::value::RawValue;
use sqlx::Row;
use uuid::Uuid;

use super::{Owner, Store, StoreError, damaged, now};
use crate::wire::{JobId, MeshId, Priority, Problem, Progress};

/// More revisions than clients can have seen of a run beyond the one that is stored: 20 a second for half
/// a day.
pub(super) const UNSEEN_REVISIONS: u32 = 1 << 20;

/// The right to write about a running job.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lease {
    pub job: JobId,
    attempt: u32,
    token: String,
}

/// A job that has been taken off the queue.
#[derive(Debug)]
pub struct Claim {
    pub lease: Lease,
    pub owner: Owner,
    pub mesh_id: MeshId,
    /// The effective settings, as JSON.
    pub request: String,
    /// Of the record, as the claim left it.
    pub revision: u64,
}

/// What a lease is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// Go on.
    Held,
    /// Stop: the job has been cancelled.
    Cancelled,
    /// Stop: the job was forgotten or is in other hands.
    Lost,
}

/// How a run ended.
#[derive(Debug, Clone)]
pub enum Ending {
    /// The planner's result, as JSON. The job is `cancelled` if that was asked for meanwhile,
    /// else `succeeded`.
    Result(Box<RawValue>),
    /// The job was cancelled before there was any result.
    Nothing,
    Problem(Problem),
}

impl Store {
    /// Takes the next job of a class off the queue. Two callers never get the same.
    ///
    /// Owners take turns: of those who wait the one with the fewest running jobs, and among these the one
    /// whose last job began first; of the owner's jobs the one that waits longest. Costs time proportional
    /// to the number of owners who wait.
    pub async fn claim(&self, class: Priority) -> Result<Option<Claim>, StoreError> {
        let token = Uuid::new_v4().to_string();
        // `waiting` steps from owner to owner through the index instead of through all jobs.
        let statement = sqlx::query(
            "WITH RECURSIVE waiting (owner) AS ( \
               SELECT min(owner) FROM jobs WHERE state = 'queued' AND priority = ?3 \
               UNION ALL \
               SELECT (SELECT min(owner) FROM jobs WHERE state = 'queued' AND priority = ?3 \
                       AND owner > waiting.owner) FROM waiting WHERE waiting.owner IS NOT NULL), \
             turn (owner) AS ( \
               SELECT owner FROM waiting WHERE owner IS NOT NULL ORDER BY \
               (SELECT count(*) FROM jobs WHERE state = 'running' AND jobs.owner = waiting.owner), \
               coalesce((SELECT max(started_at) FROM jobs WHERE jobs.owner = waiting.owner), 0), \
               owner LIMIT 1) \
             UPDATE jobs SET state = 'running', lease = ?1, started_at = max(?2, created_at), \
             revision = revision + 1 WHERE state = 'queued' AND id = \
             (SELECT min(id) FROM jobs WHERE state = 'queued' AND priority = ?3 \
              AND owner = (SELECT owner FROM turn)) \
             RETURNING id, owner, mesh_id, request, attempt, revision",
        )
        .bind(token.as_str())
        .bind(now())
        .bind(class.name());
        let rows = self.write_returning(statement).await?;
        let Some(row) = rows.first() else {
            return Ok(None);
        };
        let (id, mesh): (&str, &str) = (row.try_get("id")?, row.try_get("mesh_id")?);
        Ok(Some(Claim {
            lease: Lease {
                job: JobId::parse(id).ok_or_else(|| damaged("job id"))?,
                attempt: row.try_get("attempt")?,
                token,
            },
            owner: Owner::of_key(row.try_get("owner")?),
            mesh_id: MeshId::parse(mesh).ok_or_else(|| damaged("mesh id"))?,
            request: row.try_get("request")?,
            revision: row.try_get::<i64, _>("revision")? as u64,
        }))
    }

    /// Whether the holder of `lease` should go on.
    pub async fn hold(&self, lease: &Lease) -> Result<Hold, StoreError> {
        let Lease {
            job,
            attempt,
            token,
        } = lease;
        let cancelled: Option<bool> = sqlx::query_scalar(
            "SELECT cancel_requested FROM jobs \
             WHERE id = ?1 AND state = 'running' AND attempt = ?2 AND lease = ?3",
        )
        .bind(job.to_string())
        .bind(attempt)
        .bind(token)
        .fetch_optional(&self.readers)
        .await?;
        Ok(match cancelled {
            None => Hold::Lost,
            Some(true) => Hold::Cancelled,
            Some(false) => Hold::Held,
        })
    }

    /// Ends a job. `revision` is the last that clients have seen. Says whether the lease still
    /// held; if not, nothing has changed.
    pub async fn finish(
        &self,
        lease: &Lease,
        ending: &Ending,
        progress: &Progress,
        revision: u64,
    ) -> Result<bool, StoreError> {
        let Lease {
            job,
            attempt,
            token,
        } = lease;
        let (state, result, problem) = match ending {
            Ending::Result(result) => ("succeeded", Some(result.get()), None),
            Ending::Nothing => ("cancelled", None, None),
            Ending::Problem(problem) => {
                let problem = serde_json::to_string(problem).map_err(damaged)?;
                ("failed", None, Some(problem))
            }
        };
        let progress = serde_json::to_string(progress).map_err(damaged)?;
        let done = sqlx::query(
            "UPDATE jobs SET lease = NULL, finished_at = max(?4, started_at), result = ?6, problem = ?7, \
             progress = ?8, revision = max(revision, ?9) + 1, \
             state = CASE WHEN cancel_requested AND ?5 = 'succeeded' THEN 'cancelled' ELSE ?5 END \
             WHERE id = ?1 AND state = 'running' AND attempt = ?2 AND lease = ?3",
        )
        .bind(job.to_string())
        .bind(attempt)
        .bind(token)
        .bind(now())
        .bind(state)
        .bind(result)
        .bind(problem)
        .bind(progress)
        .bind(revision as i64)
        .execute(&self.writer)
        .await?;
        Ok(done.rows_affected() > 0)
    }

    /// Puts a job back at its place in the queue as if it had not been taken, or ends it if it
    /// was cancelled meanwhile. Says whether the lease still held.
    pub async fn release(&self, lease: &Lease, revision: u64) -> Result<bool, StoreError> {
        let Lease {
            job,
            attempt,
            token,
        } = lease;
        let done = sqlx::query(
            "UPDATE jobs SET lease = NULL, progress = NULL, \
             revision = max(revision, ?4) + 1, \
             started_at = CASE WHEN cancel_requested THEN started_at END, \
             finished_at = CASE WHEN cancel_requested THEN max(?5, started_at) END, \
             state = CASE WHEN cancel_requested THEN 'cancelled' ELSE 'queued' END \
             WHERE id = ?1 AND state = 'running' AND attempt = ?2 AND lease = ?3",
        )
        .bind(job.to_string())
        .bind(attempt)
        .bind(token)
        .bind(revision as i64)
        .bind(now())
        .execute(&self.writer)
        .await?;
        Ok(done.rows_affected() > 0)
    }

    /// Takes every running job from a holder that died with its process: back to the queue for
    /// another attempt; failed with `exhausted` if that would be more than `max_attempts`;
    /// cancelled if that was asked for. Returns how many there were.
    ///
    /// Nobody knows how far the revision had come that the dead holder showed to clients; the new one is
    /// past it for sure.
    ///
    /// Only for the start: it ends the leases of live workers too.
    pub async fn recover(&self, max_attempts: u32, exhausted: &Problem) -> Result<u64, StoreError> {
        let problem = serde_json::to_string(exhausted).map_err(damaged)?;
        let done = sqlx::query(
            "UPDATE jobs SET lease = NULL, progress = NULL, revision = revision + ?4, \
             attempt = attempt + (NOT cancel_requested AND attempt < ?1), \
             problem = CASE WHEN NOT cancel_requested AND attempt >= ?1 THEN ?2 END, \
             started_at = CASE WHEN cancel_requested OR attempt >= ?1 THEN started_at END, \
             finished_at = CASE WHEN cancel_requested OR attempt >= ?1 THEN max(?3, started_at) END, \
             state = CASE WHEN cancel_requested THEN 'cancelled' \
                          WHEN attempt >= ?1 THEN 'failed' ELSE 'queued' END \
             WHERE state = 'running'",
        )
        .bind(max_attempts)
        .bind(problem)
        .bind(now())
        .bind(UNSEEN_REVISIONS)
        .execute(&self.writer)
        .await?;
        Ok(done.rows_affected())
    }
}
