//! Jobs as workers hold them, by the clock of the database.

use std::collections::HashMap;
use std::time::Duration;

use async_trait::async_trait;
use sqlx::Row;
use uuid::Uuid;

use super::connections::PATIENCE;
use super::{PIECE_BYTES, Postgres, jobs};
use crate::store::leases::UNSEEN_REVISIONS;
use crate::store::microseconds;
use crate::store::{
    Claim, Ending, Hold, Lease, Leases, Owner, Standing, StoreError, damaged, rows,
};
use crate::wire::{JobId, Priority, Problem, Progress};

/// How long a worker may be silent before its job is given to another.
const LEASE_TIME: Duration = Duration::from_secs(10);
/// How long one piece of a result may take beyond what any statement may.
const PIECE_TIME: Duration = Duration::from_millis(500);

#[async_trait]
impl Leases for Postgres {
    fn lease_time(&self) -> Option<Duration> {
        Some(LEASE_TIME)
    }

    async fn claim(&self, first: Priority) -> Result<Option<Claim>, StoreError> {
        let token = Uuid::new_v4().to_string();
        // `waiting` steps from owner to owner through the index instead of through all jobs. An owner without rivals is
        // not compared, which would cost a look at all that it has running. Whoever meets a job that another is taking at
        // this moment passes it over. Synced as all else: a claim that a crash of the database took back would take back a
        // revision that clients have seen.
        let row = sqlx::query(
            "WITH RECURSIVE waiting (class, owner) AS ( \
               SELECT class, (SELECT owner FROM jobs WHERE state = 'queued' AND priority = class \
                              AND format <= $5 ORDER BY owner LIMIT 1) \
               FROM unnest(ARRAY[$2, $3]) AS class \
               UNION ALL \
               SELECT class, (SELECT owner FROM jobs WHERE state = 'queued' AND priority = class \
                              AND format <= $5 AND jobs.owner > waiting.owner ORDER BY owner LIMIT 1) \
               FROM waiting WHERE waiting.owner IS NOT NULL), \
             rivals (class, owner, several) AS ( \
               SELECT class, owner, count(*) OVER (PARTITION BY class) > 1 FROM waiting WHERE owner IS NOT NULL), \
             turns (class, owner) AS ( \
               SELECT class, owner FROM rivals ORDER BY class = $2 DESC, \
               CASE WHEN several THEN \
                 (SELECT count(*) FROM jobs WHERE state = 'running' AND jobs.owner = rivals.owner) END, \
               CASE WHEN several THEN \
                 coalesce((SELECT max(started_at) FROM jobs WHERE jobs.owner = rivals.owner), 0) END, \
               owner), \
             next (id) AS ( \
               SELECT first.id FROM turns CROSS JOIN LATERAL ( \
                 SELECT id FROM jobs WHERE state = 'queued' AND priority = class AND format <= $5 \
                 AND jobs.owner = turns.owner ORDER BY seq LIMIT 1 FOR UPDATE SKIP LOCKED) AS first LIMIT 1) \
             UPDATE jobs SET state = 'running', lease = $1, leased_until = now_us() + $4, \
             started_at = greatest(now_us(), created_at), revision = revision + 1 \
             FROM next WHERE jobs.id = next.id AND jobs.state = 'queued' \
             RETURNING jobs.id, owner, mesh_id, request, attempt, revision",
        )
        .bind(token.as_str())
        .bind(first.name())
        .bind(first.other().name())
        .bind(microseconds(LEASE_TIME))
        .bind(jobs::FORMAT)
        .fetch_optional(&self.writes)
        .await?;
        let Some(row) = row else {
            return Ok(None);
        };
        Ok(Some(Claim {
            lease: Lease {
                job: rows::job_id(row.try_get("id")?)?,
                attempt: u32::try_from(row.try_get::<i64, _>("attempt")?).map_err(damaged)?,
                token,
            },
            owner: Owner::of_key(row.try_get("owner")?),
            mesh_id: rows::mesh_id(row.try_get("mesh_id")?)?,
            request: row.try_get("request")?,
            revision: row.try_get::<i64, _>("revision")? as u64,
        }))
    }

    async fn hold(&self, lease: &Lease) -> Result<Hold, StoreError> {
        let cancelled: Option<bool> = sqlx::query_scalar(
            "SELECT cancel_requested FROM jobs \
             WHERE id = $1 AND state = 'running' AND attempt = $2 AND lease = $3",
        )
        .bind(lease.job.to_string())
        .bind(i64::from(lease.attempt))
        .bind(&lease.token)
        .fetch_optional(&self.pulse)
        .await?;
        Ok(held(cancelled))
    }

    async fn renew(&self, runs: &[Standing]) -> Result<Vec<Hold>, StoreError> {
        let mut ids = Vec::with_capacity(runs.len());
        let (mut attempts, mut tokens) = (Vec::new(), Vec::new());
        let (mut revisions, mut told) = (Vec::new(), Vec::new());
        for run in runs {
            ids.push(run.lease.job.to_string());
            attempts.push(i64::from(run.lease.attempt));
            tokens.push(run.lease.token.clone());
            revisions.push(run.revision as i64);
            told.push(serde_json::to_string(&run.progress).map_err(damaged)?);
        }
        let rows = sqlx::query(
            "UPDATE jobs SET leased_until = now_us() + $6, progress = run.progress, \
             revision = greatest(jobs.revision, run.revision) \
             FROM unnest($1::text[], $2::bigint[], $3::text[], $4::bigint[], $5::text[]) \
             AS run (id, attempt, lease, revision, progress) \
             WHERE jobs.id = run.id AND jobs.state = 'running' AND jobs.attempt = run.attempt \
             AND jobs.lease = run.lease \
             RETURNING jobs.id, cancel_requested, set_config('synchronous_commit', 'off', true)",
        )
        .bind(&ids)
        .bind(attempts)
        .bind(tokens)
        .bind(revisions)
        .bind(told)
        .bind(microseconds(LEASE_TIME))
        .fetch_all(&self.pulse)
        .await?;
        let mut cancelled: HashMap<String, bool> = HashMap::new();
        for row in rows {
            cancelled.insert(row.try_get("id")?, row.try_get("cancel_requested")?);
        }
        Ok(ids
            .iter()
            .map(|id| held(cancelled.get(id).copied()))
            .collect())
    }

    async fn finish(
        &self,
        lease: &Lease,
        ending: &Ending,
        progress: &Progress,
        revision: u64,
    ) -> Result<bool, StoreError> {
        let (state, result, problem) = match ending {
            Ending::Result(result) => ("succeeded", result.get(), None),
            Ending::Nothing => ("cancelled", "", None),
            Ending::Problem(problem) => {
                let problem = serde_json::to_string(problem).map_err(damaged)?;
                ("failed", "", Some(problem))
            }
        };
        let pieces: Vec<&[u8]> = result.as_bytes().chunks(PIECE_BYTES).collect();
        // A long one takes its time on the line.
        let patience = PATIENCE + PIECE_TIME.saturating_mul(pieces.len() as u32);
        let writes = self.writes.clone().patient(patience);
        let ended: i64 = sqlx::query_scalar(
            "WITH ended AS (UPDATE jobs SET lease = NULL, leased_until = NULL, \
               finished_at = greatest(now_us(), started_at), problem = $5, progress = $6, \
               revision = greatest(revision, $7) + 1, \
               state = CASE WHEN cancel_requested AND $4 = 'succeeded' THEN 'cancelled' ELSE $4 END \
               WHERE id = $1 AND state = 'running' AND attempt = $2 AND lease = $3 RETURNING id), \
             kept AS (INSERT INTO results (job_id, number, data) \
               SELECT ended.id, piece.number - 1, piece.data \
               FROM ended, unnest($8::bytea[]) WITH ORDINALITY AS piece (data, number)) \
             SELECT count(*) FROM ended",
        )
        .bind(lease.job.to_string())
        .bind(i64::from(lease.attempt))
        .bind(&lease.token)
        .bind(state)
        .bind(problem)
        .bind(serde_json::to_string(progress).map_err(damaged)?)
        .bind(revision as i64)
        .bind(pieces)
        .fetch_one(&writes)
        .await?;
        Ok(ended > 0)
    }

    async fn release(&self, lease: &Lease, revision: u64) -> Result<bool, StoreError> {
        let done = sqlx::query(
            "UPDATE jobs SET lease = NULL, leased_until = NULL, progress = NULL, \
             revision = greatest(revision, $4) + 1, \
             started_at = CASE WHEN cancel_requested THEN started_at END, \
             finished_at = CASE WHEN cancel_requested THEN greatest(now_us(), started_at) END, \
             state = CASE WHEN cancel_requested THEN 'cancelled' ELSE 'queued' END \
             WHERE id = $1 AND state = 'running' AND attempt = $2 AND lease = $3",
        )
        .bind(lease.job.to_string())
        .bind(i64::from(lease.attempt))
        .bind(&lease.token)
        .bind(revision as i64)
        .execute(&self.writes)
        .await?;
        Ok(done.rows_affected() > 0)
    }

    async fn recover(
        &self,
        max_attempts: u32,
        exhausted: &Problem,
    ) -> Result<Vec<JobId>, StoreError> {
        // Several may do this at the same moment; each takes what the others leave.
        let rows = sqlx::query(
            "WITH lost AS (SELECT id FROM jobs WHERE state = 'running' AND leased_until < now_us() \
                           FOR UPDATE SKIP LOCKED) \
             UPDATE jobs SET lease = NULL, leased_until = NULL, progress = NULL, \
             revision = revision + $3, \
             attempt = attempt + CASE WHEN NOT cancel_requested AND attempt < $1 THEN 1 ELSE 0 END, \
             problem = CASE WHEN NOT cancel_requested AND attempt >= $1 THEN $2 END, \
             started_at = CASE WHEN cancel_requested OR attempt >= $1 THEN started_at END, \
             finished_at = CASE WHEN cancel_requested OR attempt >= $1 \
                           THEN greatest(now_us(), started_at) END, \
             state = CASE WHEN cancel_requested THEN 'cancelled' \
                          WHEN attempt >= $1 THEN 'failed' ELSE 'queued' END \
             FROM lost WHERE jobs.id = lost.id AND jobs.state = 'running' RETURNING jobs.id",
        )
        .bind(i64::from(max_attempts))
        .bind(serde_json::to_string(exhausted).map_err(damaged)?)
        .bind(i64::from(UNSEEN_REVISIONS))
        .fetch_all(&self.pulse)
        .await?;
        rows.iter()
            .map(|row| rows::job_id(row.try_get("id")?))
            .collect()
    }
}

fn held(cancelled: Option<bool>) -> Hold {
    match cancelled {
        None => Hold::Lost,
        Some(true) => Hold::Cancelled,
        Some(false) => Hold::Held,
    }
}
