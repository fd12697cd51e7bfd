//! Jobs as clients ask for them: submit, read, list, cancel, forget.

use async_trait::async_trait;

use super::submissions::Submission;
use super::{Owner, StoreError};
use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId, Priority};

/// A job that is to be queued.
#[derive(Debug)]
pub struct NewJob {
    pub owner: Owner,
    /// The effective settings, as JSON.
    pub request: String,
    pub label: Option<String>,
    pub priority: Priority,
    /// The most jobs that may be queued, this one among them.
    pub capacity: u32,
    /// The most jobs of this owner among them.
    pub owner_capacity: Option<u32>,
    /// The key that it is submitted under, so that it is queued only once.
    pub submission: Option<Submission>,
}

/// Why a job was not queued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    UnknownMesh,
    QueueFull,
    /// As many jobs of this owner wait as are allowed.
    OwnerQueueFull,
    /// The meshes of this owner take as much room as is allowed.
    OwnerStorageFull,
    /// Another submission under the same key was faster.
    KeyInUse,
}

/// Which jobs of an owner to list; `None` means any.
#[derive(Debug, Clone, Default)]
pub struct JobFilter {
    pub owner: Owner,
    pub state: Option<JobState>,
    /// As the client wrote it; a text that cannot be an id matches no job.
    pub mesh_id: Option<String>,
    /// As the client wrote it, too.
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

    /// Returns how many jobs wait.
    async fn queued(&self) -> Result<u32, StoreError>;

    /// Returns how many jobs wait and run, and which waits longest. Costs time in proportion to these at most.
    async fn unfinished_jobs(&self) -> Result<Unfinished, StoreError>;

    /// Returns how many jobs are in each final state; a state without any may be missing. Costs time in
    /// proportion to these jobs at most.
    async fn ended_jobs(&self) -> Result<Vec<(JobState, u64)>, StoreError>;

    /// Returns a job of an owner with its result.
    async fn job(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError>;

    /// Returns a job of an owner without its result.
    async fn job_without_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<Option<JobRecord>, StoreError>;

    /// Returns at most `limit` jobs without their results, newest first, from where `cursor` ended; `None` when the cursor is not one of this list.
    async fn jobs(
        &self,
        filter: &JobFilter,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<JobPage>, StoreError>;

    /// Returns the revisions of those of these jobs that exist.
    async fn revisions(&self, jobs: &[JobId]) -> Result<Vec<(JobId, u64)>, StoreError>;

    /// Ends a queued job, or marks a running one so that it ends as cancelled whatever becomes
    /// of its worker. `None` when there is no such job or it has ended.
    async fn cancel(&self, owner: &Owner, id: JobId) -> Result<Option<JobRecord>, StoreError>;

    /// Forgets a job, whatever its state. Returns whether there was one.
    async fn delete_job(&self, owner: &Owner, id: JobId) -> Result<bool, StoreError>;
}
