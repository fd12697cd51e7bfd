//! Jobs as workers hold them.

use std::time::Duration;

use async_trait::async_trait;
use sqlx::FromRow;
use uuid::Uuid;

use super::statement::Statement;
use super::{Engine, rows};
use crate::store::{
    Claim, Lease, LeaseStatus, Leases, Owner, Renewal, RunOutcome, StoreError, damaged,
};
use crate::wire::{JobId, Priority, Problem, Progress};

/// The operations on leases that each engine implements itself.
#[async_trait]
pub trait LeaseEngine: Engine {
    /// How long a lease lasts; `None` where it lasts as long as the process.
    const LEASE_TIME: Option<Duration>;

    /// Takes the next job off the queue under a lease with this token.
    async fn take_next(&self, token: &str, first: Priority)
    -> Result<Option<ClaimRow>, StoreError>;

    /// Returns what a statement about a lease finds, which must not wait in line behind the rest.
    async fn read_lease(&self, statement: Statement) -> Result<Option<(bool,)>, StoreError>;

    /// Lets leases last, and says of each whether its holder should go on.
    async fn renew_leases(&self, runs: &[Renewal]) -> Result<Vec<LeaseStatus>, StoreError>;

    /// Ends a job whose lease still holds. Returns how many there were.
    async fn end_job(&self, lease: &Lease, end: &End<'_>, revision: i64)
    -> Result<u64, StoreError>;

    /// Puts a job back whose lease still holds. Returns how many there were.
    async fn put_back(&self, lease: &Lease, revision: i64) -> Result<u64, StoreError>;

    /// Takes running jobs from holders that are dead, and returns them.
    async fn take_from_the_dead(
        &self,
        max_attempts: u32,
        exhausted: String,
    ) -> Result<Vec<(String,)>, StoreError>;
}

/// A job that has been taken off the queue.
#[derive(FromRow)]
pub struct ClaimRow {
    id: String,
    owner: String,
    mesh_id: String,
    request: String,
    attempt: i64,
    revision: i64,
}

/// How a run ended, as it is written down.
pub struct End<'e> {
    pub state: &'static str,
    pub result: Option<&'e str>,
    pub problem: Option<String>,
    pub progress: String,
}

impl<'e> End<'e> {
    fn new(outcome: &'e RunOutcome, progress: &Progress) -> Result<Self, StoreError> {
        let (state, result, problem) = match outcome {
            RunOutcome::Result(result) => ("succeeded", Some(result.get()), None),
            RunOutcome::Cancelled => ("cancelled", None, None),
            RunOutcome::Problem(problem) => ("failed", None, Some(json(problem)?)),
        };
        Ok(Self {
            state,
            result,
            problem,
            progress: json(progress)?,
        })
    }
}

#[async_trait]
impl<E: LeaseEngine> Leases for E {
    fn lease_time(&self) -> Option<Duration> {
        E::LEASE_TIME
    }

    async fn claim(&self, first: Priority) -> Result<Option<Claim>, StoreError> {
        let token = Uuid::new_v4().to_string();
        let Some(row) = self.take_next(&token, first).await? else {
            return Ok(None);
        };
        Ok(Some(Claim {
            lease: Lease {
                job: rows::job_id(&row.id)?,
                attempt: rows::count(row.attempt)?,
                token,
            },
            owner: Owner::of_key(&row.owner),
            mesh_id: rows::mesh_id(&row.mesh_id)?,
            request: row.request,
            revision: row.revision as u64,
        }))
    }

    async fn lease_status(&self, lease: &Lease) -> Result<LeaseStatus, StoreError> {
        let statement = Statement::new(
            "SELECT cancel_requested FROM jobs \
             WHERE id = $1 AND state = 'running' AND attempt = $2 AND lease = $3",
        )
        .bind(lease.job.to_string())
        .bind(lease.attempt)
        .bind(lease.token.as_str());
        let found = self.read_lease(statement).await?;
        Ok(status(found.map(|(cancelled,)| cancelled)))
    }

    async fn renew(&self, runs: &[Renewal]) -> Result<Vec<LeaseStatus>, StoreError> {
        self.renew_leases(runs).await
    }

    async fn finish(
        &self,
        lease: &Lease,
        outcome: &RunOutcome,
        progress: &Progress,
        revision: u64,
    ) -> Result<bool, StoreError> {
        let end = End::new(outcome, progress)?;
        Ok(self.end_job(lease, &end, revision as i64).await? > 0)
    }

    async fn release(&self, lease: &Lease, revision: u64) -> Result<bool, StoreError> {
        Ok(self.put_back(lease, revision as i64).await? > 0)
    }

    async fn recover(
        &self,
        max_attempts: u32,
        exhausted: &Problem,
    ) -> Result<Vec<JobId>, StoreError> {
        let exhausted = json(exhausted)?;
        let jobs = self.take_from_the_dead(max_attempts, exhausted).await?;
        jobs.iter().map(|(id,)| rows::job_id(id)).collect()
    }
}

/// The state of a lease, by whether its job is to be cancelled; `None` if no job has this lease.
pub fn status(cancelled: Option<bool>) -> LeaseStatus {
    match cancelled {
        None => LeaseStatus::Lost,
        Some(true) => LeaseStatus::Cancelled,
        Some(false) => LeaseStatus::Held,
    }
}

fn json(value: &impl serde::Serialize) -> Result<String, StoreError> {
    serde_json::to_string(value).map_err(damaged)
}
