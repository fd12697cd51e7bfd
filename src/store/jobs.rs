//! Jobs as clients ask for them: submit, read, list, cancel, forget.

use async_trait::async_trait;

use super::submissions::Submission;
use super::{Owner, StoreError};
use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId, Priority};

/// A job to be queued.
#[derive(Debug)]
pub struct NewJob {
    pub owner: Owner,
    /// The effective settings, as JSON.
    pub request: String,
    pub label: Option<String>,
    pub priority: Priority,
    /// Most jobs that may be queued, this one among them.
    pub capacity: u32,
    /// As many of them may be of this owner.
    pub share: Option<u32>,
    /// Under which key it is submitted, and only once.
    pub submission: Option<Submission>,
}

/// Why a job was not queued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    UnknownMesh,
    QueueFull,
    /// As many jobs of this owner wait as may.
    ShareUsed,
    /// The meshes of this owner take as much room as they may.
    RoomUsed,
    /// Another submission under the same key was faster.
    Submitted,
}

/// Which jobs of an owner to list; `None` means any.
#[derive(Debug, Clone, Default)]
pub struct JobFilter {
    pub owner: Owner,
    pub state: Option<JobState>,
    /// As clients write it; what cannot be an id is on no job.
    pub mesh_id: Option<String>,
    /// As clients write it, too.
    pub batch_id: Option<String>,
}

/// The jobs in the store that have not ended.
#[derive(Debug, Clone)]
pub struct Unfinished {
    pub queued: u64,
    pub running: u64,
    /// The one that waits longest.
    pub oldest_queued: Option<JobId>,
}

/// The jobs of a store.
#[async_trait]
pub trait Jobs {
    /// Queues a job; it is on stable storage once this returns it. Must be run to its end.
    async fn submit(
        &self,
        mesh: &MeshId,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError>;

    /// How many jobs wait.
    async fn queued(&self) -> Result<u32, StoreError>;

    /// How many jobs wait and run, and which waits longest. Costs time in proportion to these at most.
    async fn unfinished_jobs(&self) -> Result<Unfinished, StoreError>;

    /// How many of the jobs that are kept ended in each way; a state without any may be missing. Costs time in
    /// proportion to them at most.
    async fn ended_jobs(&self) -> Result<Vec<(JobState, u64)>, StoreError>;

    /// A job of an owner with its result.
    async fn job(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError>;

    /// A job of an owner without its result.
    async fn job_without_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<Option<JobRecord>, StoreError>;

    /// At most `limit` jobs without their results, newest first, from where `cursor` ended.
    /// `None` when the cursor is not one of this list.
    async fn jobs(
        &self,
        filter: &JobFilter,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<JobPage>, StoreError>;

    /// The revisions of those of these jobs that are there.
    async fn revisions(&self, jobs: &[JobId]) -> Result<Vec<(JobId, u64)>, StoreError>;

    /// Ends a queued job, or marks a running one so that it ends as cancelled whatever becomes
    /// of its worker. `None` when there is no such job or it has ended.
    async fn cancel(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError>;

    /// Forgets a job, whatever its state. Says whether there was one.
    async fn delete_job(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError>;
}
