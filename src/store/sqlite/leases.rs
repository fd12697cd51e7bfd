//! Jobs as the workers of this process hold them.

use std::time::Duration;

use async_trait::async_trait;

use super::{Sqlite, now};
use crate::store::common::leases::{ClaimRow, End, LeaseEngine};
use crate::store::common::statement::Statement;
use crate::store::leases::UNSEEN_REVISIONS;
use crate::store::{Lease, LeaseStatus, Leases, Renewal, StoreError};
use crate::wire::Priority;

#[async_trait]
impl LeaseEngine for Sqlite {
    const LEASE_TIME: Option<Duration> = None;

    async fn take_next(
        &self,
        token: &str,
        first: Priority,
    ) -> Result<Option<ClaimRow>, StoreError> {
        // `waiting` steps from owner to owner through the index instead of through all jobs. The least id is asked for
        // by itself: from a join SQLite reads all that wait.
        let statement = sqlx::query(
            "WITH RECURSIVE classes (class) AS (VALUES ($3), ($4)), \
             waiting (class, owner) AS ( \
               SELECT class, (SELECT min(owner) FROM jobs WHERE state = 'queued' AND priority = class) \
               FROM classes \
               UNION ALL \
               SELECT class, (SELECT min(owner) FROM jobs WHERE state = 'queued' AND priority = class \
                              AND owner > waiting.owner) FROM waiting WHERE waiting.owner IS NOT NULL), \
             turn (class, owner) AS ( \
               SELECT class, owner FROM waiting WHERE owner IS NOT NULL ORDER BY class = $3 DESC, \
               (SELECT count(*) FROM jobs WHERE state = 'running' AND jobs.owner = waiting.owner), \
               coalesce((SELECT max(started_at) FROM jobs WHERE jobs.owner = waiting.owner), 0), \
               owner LIMIT 1) \
             UPDATE jobs SET state = 'running', lease = $1, started_at = max($2, created_at), \
             revision = revision + 1 WHERE state = 'queued' AND id = \
             (SELECT (SELECT min(id) FROM jobs WHERE state = 'queued' AND priority = turn.class \
                      AND jobs.owner = turn.owner) FROM turn) \
             RETURNING id, owner, mesh_id, request, attempt, revision",
        )
        .bind(token)
        .bind(now())
        .bind(first.name())
        .bind(first.other().name());
        self.writer.run(statement).await?.first()
    }

    async fn read_lease(&self, statement: Statement) -> Result<Option<(bool,)>, StoreError> {
        self.readers.read(statement.for_sqlite()?).await?.first()
    }

    async fn renew_leases(&self, runs: &[Renewal]) -> Result<Vec<LeaseStatus>, StoreError> {
        let mut found = Vec::with_capacity(runs.len());
        for run in runs {
            found.push(self.lease_status(&run.lease).await?);
        }
        Ok(found)
    }

    async fn end_job(
        &self,
        lease: &Lease,
        end: &End<'_>,
        revision: i64,
    ) -> Result<u64, StoreError> {
        let finish = || async {
            let statement = sqlx::query(
                "UPDATE jobs SET lease = NULL, finished_at = max($4, started_at), result = $6, \
                 problem = $7, progress = $8, revision = max(revision, $9) + 1, \
                 state = CASE WHEN cancel_requested AND $5 = 'succeeded' THEN 'cancelled' ELSE $5 END \
                 WHERE id = $1 AND state = 'running' AND attempt = $2 AND lease = $3",
            )
            .bind(lease.job.to_string())
            .bind(lease.attempt)
            .bind(&lease.token)
            .bind(now())
            .bind(end.state)
            .bind(end.result)
            .bind(end.problem.as_deref())
            .bind(&end.progress)
            .bind(revision);
            Ok(self.writer.run(statement).await?.changed())
        };
        self.with_reserve(finish).await
    }

    async fn put_back(&self, lease: &Lease, revision: i64) -> Result<u64, StoreError> {
        let release = || async {
            let statement = sqlx::query(
                "UPDATE jobs SET lease = NULL, progress = NULL, \
                 revision = max(revision, $4) + 1, \
                 started_at = CASE WHEN cancel_requested THEN started_at END, \
                 finished_at = CASE WHEN cancel_requested THEN max($5, started_at) END, \
                 state = CASE WHEN cancel_requested THEN 'cancelled' ELSE 'queued' END \
                 WHERE id = $1 AND state = 'running' AND attempt = $2 AND lease = $3",
            )
            .bind(lease.job.to_string())
            .bind(lease.attempt)
            .bind(&lease.token)
            .bind(revision)
            .bind(now());
            Ok(self.writer.run(statement).await?.changed())
        };
        self.with_reserve(release).await
    }

    /// The holders died with the process before this one: every job that runs is taken.
    async fn take_from_the_dead(
        &self,
        max_attempts: u32,
        exhausted: String,
    ) -> Result<Vec<(String,)>, StoreError> {
        let recover = || async {
            let statement = sqlx::query(
                "UPDATE jobs SET lease = NULL, progress = NULL, revision = revision + $4, \
                 attempt = attempt + (NOT cancel_requested AND attempt < $1), \
                 problem = CASE WHEN NOT cancel_requested AND attempt >= $1 THEN $2 END, \
                 started_at = CASE WHEN cancel_requested OR attempt >= $1 THEN started_at END, \
                 finished_at = CASE WHEN cancel_requested OR attempt >= $1 THEN max($3, started_at) END, \
                 state = CASE WHEN cancel_requested THEN 'cancelled' \
                              WHEN attempt >= $1 THEN 'failed' ELSE 'queued' END \
                 WHERE state = 'running' RETURNING id",
            )
            .bind(max_attempts)
            .bind(&exhausted)
            .bind(now())
            .bind(UNSEEN_REVISIONS);
            self.writer.run(statement).await?.all()
        };
        self.with_reserve(recover).await
    }
}
