//! Jobs as the workers of this process hold them.

use std::time::Duration;

use async_trait::async_trait;
use sqlx::Row;
use uuid::Uuid;

use super::{Sqlite, now};
use crate::store::leases::UNSEEN_REVISIONS;
use crate::store::{
    Claim, Ending, Hold, Lease, Leases, Owner, Standing, StoreError, damaged, rows,
};
use crate::wire::{JobId, Priority, Problem, Progress};

#[async_trait]
impl Leases for Sqlite {
    fn lease_time(&self) -> Option<Duration> {
        None
    }

    async fn claim(&self, first: Priority) -> Result<Option<Claim>, StoreError> {
        let token = Uuid::new_v4().to_string();
        // `waiting` steps from owner to owner through the index instead of through all jobs. The least id is asked for
        // by itself: from a join SQLite reads all that wait.
        let statement = sqlx::query(
            "WITH RECURSIVE classes (class) AS (VALUES (?3), (?4)), \
             waiting (class, owner) AS ( \
               SELECT class, (SELECT min(owner) FROM jobs WHERE state = 'queued' AND priority = class) \
               FROM classes \
               UNION ALL \
               SELECT class, (SELECT min(owner) FROM jobs WHERE state = 'queued' AND priority = class \
                              AND owner > waiting.owner) FROM waiting WHERE waiting.owner IS NOT NULL), \
             turn (class, owner) AS ( \
               SELECT class, owner FROM waiting WHERE owner IS NOT NULL ORDER BY class = ?3 DESC, \
               (SELECT count(*) FROM jobs WHERE state = 'running' AND jobs.owner = waiting.owner), \
               coalesce((SELECT max(started_at) FROM jobs WHERE jobs.owner = waiting.owner), 0), \
               owner LIMIT 1) \
             UPDATE jobs SET state = 'running', lease = ?1, started_at = max(?2, created_at), \
             revision = revision + 1 WHERE state = 'queued' AND id = \
             (SELECT (SELECT min(id) FROM jobs WHERE state = 'queued' AND priority = turn.class \
                      AND jobs.owner = turn.owner) FROM turn) \
             RETURNING id, owner, mesh_id, request, attempt, revision",
        )
        .bind(token.as_str())
        .bind(now())
        .bind(first.name())
        .bind(first.other().name());
        let rows = self.write_returning(statement).await?;
        let Some(row) = rows.first() else {
            return Ok(None);
        };
        let (id, mesh): (&str, &str) = (row.try_get("id")?, row.try_get("mesh_id")?);
        Ok(Some(Claim {
            lease: Lease {
                job: rows::job_id(id)?,
                attempt: row.try_get("attempt")?,
                token,
            },
            owner: Owner::of_key(row.try_get("owner")?),
            mesh_id: rows::mesh_id(mesh)?,
            request: row.try_get("request")?,
            revision: row.try_get::<i64, _>("revision")? as u64,
        }))
    }

    async fn hold(&self, lease: &Lease) -> Result<Hold, StoreError> {
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

    async fn renew(&self, runs: &[Standing]) -> Result<Vec<Hold>, StoreError> {
        let mut holds = Vec::with_capacity(runs.len());
        for run in runs {
            holds.push(self.hold(&run.lease).await?);
        }
        Ok(holds)
    }

    async fn finish(
        &self,
        lease: &Lease,
        ending: &Ending,
        progress: &Progress,
        revision: u64,
    ) -> Result<bool, StoreError> {
        let (state, result, problem) = match ending {
            Ending::Result(result) => ("succeeded", Some(result.get()), None),
            Ending::Nothing => ("cancelled", None, None),
            Ending::Problem(problem) => {
                let problem = serde_json::to_string(problem).map_err(damaged)?;
                ("failed", None, Some(problem))
            }
        };
        let progress = serde_json::to_string(progress).map_err(damaged)?;
        let finish = || async {
            let done = sqlx::query(
                "UPDATE jobs SET lease = NULL, finished_at = max(?4, started_at), result = ?6, \
                 problem = ?7, progress = ?8, revision = max(revision, ?9) + 1, \
                 state = CASE WHEN cancel_requested AND ?5 = 'succeeded' THEN 'cancelled' ELSE ?5 END \
                 WHERE id = ?1 AND state = 'running' AND attempt = ?2 AND lease = ?3",
            )
            .bind(lease.job.to_string())
            .bind(lease.attempt)
            .bind(&lease.token)
            .bind(now())
            .bind(state)
            .bind(result)
            .bind(problem.as_deref())
            .bind(&progress)
            .bind(revision as i64)
            .execute(&self.writer)
            .await?;
            Ok(done.rows_affected() > 0)
        };
        self.with_reserve(finish).await
    }

    async fn release(&self, lease: &Lease, revision: u64) -> Result<bool, StoreError> {
        let release = || async {
            let done = sqlx::query(
                "UPDATE jobs SET lease = NULL, progress = NULL, \
                 revision = max(revision, ?4) + 1, \
                 started_at = CASE WHEN cancel_requested THEN started_at END, \
                 finished_at = CASE WHEN cancel_requested THEN max(?5, started_at) END, \
                 state = CASE WHEN cancel_requested THEN 'cancelled' ELSE 'queued' END \
                 WHERE id = ?1 AND state = 'running' AND attempt = ?2 AND lease = ?3",
            )
            .bind(lease.job.to_string())
            .bind(lease.attempt)
            .bind(&lease.token)
            .bind(revision as i64)
            .bind(now())
            .execute(&self.writer)
            .await?;
            Ok(done.rows_affected() > 0)
        };
        self.with_reserve(release).await
    }

    async fn recover(
        &self,
        max_attempts: u32,
        exhausted: &Problem,
    ) -> Result<Vec<JobId>, StoreError> {
        let problem = serde_json::to_string(exhausted).map_err(damaged)?;
        let recover = || async {
            let statement = sqlx::query(
                "UPDATE jobs SET lease = NULL, progress = NULL, revision = revision + ?4, \
                 attempt = attempt + (NOT cancel_requested AND attempt < ?1), \
                 problem = CASE WHEN NOT cancel_requested AND attempt >= ?1 THEN ?2 END, \
                 started_at = CASE WHEN cancel_requested OR attempt >= ?1 THEN started_at END, \
                 finished_at = CASE WHEN cancel_requested OR attempt >= ?1 THEN max(?3, started_at) END, \
                 state = CASE WHEN cancel_requested THEN 'cancelled' \
                              WHEN attempt >= ?1 THEN 'failed' ELSE 'queued' END \
                 WHERE state = 'running' RETURNING id",
            )
            .bind(max_attempts)
            .bind(&problem)
            .bind(now())
            .bind(UNSEEN_REVISIONS);
            self.write_returning(statement).await
        };
        let rows = self.with_reserve(recover).await?;
        rows.iter()
            .map(|row| rows::job_id(row.try_get("id")?))
            .collect()
    }
}
