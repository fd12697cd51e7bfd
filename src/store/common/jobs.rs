//! Jobs as clients ask for them.

use async_trait::async_trait;

use super::rows::{self, JobRow, job_columns, job_columns_with_mesh};
use super::statement::Statement;
use super::{Engine, cursor, first, one};
use crate::store::{JobFilter, Jobs, NewJob, Owner, Refusal, StoreError, Unfinished};
use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId};

/// The operations on jobs that each engine implements itself.
#[async_trait]
pub trait JobEngine: Engine {
    /// How many jobs wait.
    const COUNT_QUEUED: &'static str;
    /// How many jobs wait, how many run, and the id of the one that waits longest.
    const COUNT_UNFINISHED: &'static str;
    /// Each final state with the number of its jobs.
    const COUNT_ENDED: &'static str;

    /// Queues a job if there is such a mesh and room.
    async fn insert_job(
        &self,
        mesh: &MeshId,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError>;

    /// A job with its result.
    async fn job_with_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<Option<JobRecord>, StoreError>;

    /// Ends a job that waits, or marks one that runs.
    async fn cancel_job(&self, owner: &Owner, id: JobId) -> Result<Option<JobRow>, StoreError>;
}

#[async_trait]
impl<E: JobEngine> Jobs for E {
    async fn submit(
        &self,
        mesh: &MeshId,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        self.insert_job(mesh, job).await
    }

    async fn queued(&self) -> Result<u32, StoreError> {
        let (queued,): (i64,) = one(self, Statement::new(E::COUNT_QUEUED)).await?;
        rows::count(queued)
    }

    async fn unfinished_jobs(&self) -> Result<Unfinished, StoreError> {
        let (queued, running, oldest): (i64, i64, Option<String>) =
            one(self, Statement::new(E::COUNT_UNFINISHED)).await?;
        Ok(Unfinished {
            queued: queued as u64,
            running: running as u64,
            oldest_queued: oldest.as_deref().map(rows::job_id).transpose()?,
        })
    }

    async fn ended_jobs(&self) -> Result<Vec<(JobState, u64)>, StoreError> {
        let counts: Vec<(String, i64)> = self.read(Statement::new(E::COUNT_ENDED)).await?;
        let count = |(state, jobs): &(String, i64)| Ok((rows::job_state(state)?, *jobs as u64));
        counts.iter().map(count).collect()
    }

    async fn job(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        self.job_with_result(owner, id).await
    }

    async fn job_without_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<Option<JobRecord>, StoreError> {
        let statement = Statement::new(concat!(
            "SELECT ",
            job_columns_with_mesh!(),
            " FROM jobs WHERE id = $1 AND owner = $2"
        ));
        let statement = statement.bind(id.to_string()).bind(owner.as_str());
        let row: Option<JobRow> = first(self, statement).await?;
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
        // Conditions are appended one by one: with `$2 IS NULL OR state = $2` SQLite would use no index.
        let mut statement = Statement::new(concat!(
            "SELECT ",
            job_columns!(),
            " FROM jobs WHERE owner = $1"
        ))
        .bind(owner.as_str());
        if let Some(state) = state {
            statement = statement.push(" AND state = ", state.name());
        }
        if let Some(mesh_id) = mesh_id {
            statement = statement.push(" AND mesh_id = ", mesh_id.as_str());
        }
        if let Some(batch_id) = batch_id {
            statement = statement.push(" AND batch_id = ", batch_id.as_str());
        }
        if let Some(cursor) = cursor {
            let Some(last) = cursor::decode(LIST, cursor).and_then(JobId::parse) else {
                return Ok(None);
            };
            statement = statement.push(" AND id < ", last.to_string());
        }
        let limit = cursor::limit(limit);
        let statement = statement.push(" ORDER BY id DESC LIMIT ", limit.asked_for());
        let rows: Vec<JobRow> = self.read(statement).await?;
        let jobs = rows.into_iter().map(JobRecord::try_from);
        let (jobs, next_cursor) =
            limit.page(LIST, jobs.collect::<Result<_, _>>()?, |job: &JobRecord| {
                job.id.to_string()
            });
        Ok(Some(JobPage { jobs, next_cursor }))
    }

    async fn revisions(&self, jobs: &[JobId]) -> Result<Vec<(JobId, u64)>, StoreError> {
        let ids = jobs.iter().map(JobId::to_string).collect();
        let statement =
            Statement::new("SELECT id, revision FROM jobs WHERE ").push_in_list::<E>("id", ids);
        let rows: Vec<(String, i64)> = self.read(statement).await?;
        rows.iter().map(rows::job_and_revision).collect()
    }

    async fn cancel(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError> {
        let row = self.cancel_job(owner, id).await?;
        row.map(TryInto::try_into).transpose()
    }

    async fn delete_job(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError> {
        let statement = Statement::new("DELETE FROM jobs WHERE id = $1 AND owner = $2")
            .bind(id.to_string())
            .bind(owner.as_str());
        Ok(self.change(statement).await? > 0)
    }
}

impl Refusal {
    /// Why a job was not queued, by whether its mesh is here and whether the queue has room for one of any owner.
    pub(in crate::store) fn of_job(has_mesh: bool, has_room: bool) -> Self {
        match (has_mesh, has_room) {
            (false, _) => Self::UnknownMesh,
            (true, false) => Self::QueueFull,
            (true, true) => Self::OwnerQueueFull,
        }
    }
}
