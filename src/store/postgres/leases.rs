//! Jobs as workers hold them, by the clock of the database.

use std::collections::HashMap;
use std::time::Duration;

use async_trait::async_trait;

use super::connections::PATIENCE;
use super::{PIECE_BYTES, Postgres, jobs};
use crate::store::common::leases::{ClaimRow, End, LeaseEngine, status};
use crate::store::common::statement::Statement;
use crate::store::leases::UNSEEN_REVISIONS;
use crate::store::microseconds;
use crate::store::{Lease, LeaseStatus, Renewal, StoreError, damaged};
use crate::wire::Priority;

/// How long a worker may be silent before its job is given to another.
const LEASE_TIME: Duration = Duration::from_secs(10);
/// How long one piece of a result may take beyond what any statement may.
const PIECE_TIME: Duration = Duration::from_millis(500);

#[async_trait]
impl LeaseEngine for Postgres {
    const LEASE_TIME: Option<Duration> = Some(LEASE_TIME);

    async fn take_next(
        &self,
        token: &str,
        first: Priority,
    ) -> Result<Option<ClaimRow>, StoreError> {
        // `waiting` steps from owner to owner through the index instead of through all jobs. An owner without rivals is
        // not compared, which would cost a look at all that it has running. Whoever meets a job that another is taking at
        // this moment passes it over. Synced as all else: a claim that a crash of the database took back would take back a
        // revision that clients have seen.
        let statement = sqlx::query(
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
        .bind(token)
        .bind(first.name())
        .bind(first.other().name())
        .bind(microseconds(LEASE_TIME))
        .bind(jobs::FORMAT);
        self.writes.run(statement).await?.first()
    }

    async fn read_lease(&self, statement: Statement) -> Result<Option<(bool,)>, StoreError> {
        self.urgent.run(statement.for_postgres()).await?.first()
    }

    async fn renew_leases(&self, runs: &[Renewal]) -> Result<Vec<LeaseStatus>, StoreError> {
        let mut ids = Vec::with_capacity(runs.len());
        let (mut attempts, mut tokens) = (Vec::new(), Vec::new());
        let (mut revisions, mut progresses) = (Vec::new(), Vec::new());
        for run in runs {
            ids.push(run.lease.job.to_string());
            attempts.push(i64::from(run.lease.attempt));
            tokens.push(run.lease.token.clone());
            revisions.push(run.revision as i64);
            progresses.push(serde_json::to_string(&run.progress).map_err(damaged)?);
        }
        let statement = sqlx::query(
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
        .bind(progresses)
        .bind(microseconds(LEASE_TIME));
        let renewed: Vec<(String, bool, String)> = self.urgent.run(statement).await?.all()?;
        let cancelled = renewed
            .into_iter()
            .map(|(id, cancelled, _)| (id, cancelled));
        let cancelled: HashMap<String, bool> = cancelled.collect();
        let of = |id| status(cancelled.get(id).copied());
        Ok(ids.iter().map(of).collect())
    }

    async fn end_job(
        &self,
        lease: &Lease,
        end: &End<'_>,
        revision: i64,
    ) -> Result<u64, StoreError> {
        let result = end.result.unwrap_or_default();
        let pieces: Vec<&[u8]> = result.as_bytes().chunks(PIECE_BYTES).collect();
        // A long result takes its time on the line.
        let patience = PATIENCE + PIECE_TIME.saturating_mul(pieces.len() as u32);
        let writes = self.writes.clone().patient(patience);
        let statement = sqlx::query(
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
        .bind(end.state)
        .bind(end.problem.as_deref())
        .bind(&end.progress)
        .bind(revision)
        .bind(pieces);
        let (ended,) = writes.run(statement).await?.one::<(i64,)>()?;
        Ok(ended as u64)
    }

    async fn put_back(&self, lease: &Lease, revision: i64) -> Result<u64, StoreError> {
        let statement = sqlx::query(
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
        .bind(revision);
        Ok(self.writes.run(statement).await?.changed())
    }

    async fn take_from_the_dead(
        &self,
        max_attempts: u32,
        exhausted: String,
    ) -> Result<Vec<(String,)>, StoreError> {
        // Several may do this at the same moment; each takes what the others leave.
        let statement = sqlx::query(
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
        .bind(exhausted)
        .bind(i64::from(UNSEEN_REVISIONS));
        self.urgent.run(statement).await?.all()
    }
}
