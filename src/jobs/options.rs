//! The options with which a service starts.

use std::path::PathBuf;
use std::time::Duration;

use super::ingest::IngestLimits;
use super::webhooks;
use crate::store::Owner;

/// The settings of a [`super::Service`].
#[derive(Debug, Clone)]
pub struct Options {
    /// The location of the store.
    pub store: Location,
    /// The role of this process.
    pub role: Role,
    /// How it plans.
    pub planning: PlanningOptions,
    /// The limits on the size of a mesh and on the time to read it.
    pub ingest: IngestLimits,
    /// Most jobs that may wait.
    pub queue_capacity: u32,
    /// The quotas of each owner.
    pub quota: Quota,
    /// How long ended jobs and unused meshes are kept; `None` is for ever.
    pub retention: Option<Duration>,
    /// Most clients that may follow jobs at the same time.
    pub followers: usize,
    /// Bytes of free disk below which no new work is accepted.
    pub min_free_disk: u64,
    /// Which receivers may be called at the end of a job.
    pub webhooks: webhooks::Options,
}

/// How a process plans.
#[derive(Debug, Clone)]
pub struct PlanningOptions {
    /// Jobs planned at the same time.
    pub workers: usize,
    /// Threads that plan one job.
    pub threads_per_job: usize,
    /// How often a job is begun at most when the process dies while it runs.
    pub max_attempts: u32,
    /// Bytes of memory that the process may take before a run is stopped; `None` is no limit.
    pub max_memory: Option<u64>,
    /// How long running jobs may go on when the process shuts down, before they are put back.
    pub drain: Duration,
}

/// The location of a store.
#[derive(Debug, Clone)]
pub enum Location {
    /// A folder with a database and the meshes, for this process alone; created when missing.
    Folder(PathBuf),
    /// The address of a PostgreSQL database, `postgres://...`, that others may share.
    Database(String),
}

/// The role of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Serves clients, and plans if it has workers.
    Server,
    /// Only plans.
    Worker,
}

/// The quotas of one owner; requests without a key have none.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quota {
    /// Most jobs that wait.
    pub queued: Option<u32>,
    /// Most bytes of mesh files.
    pub mesh_bytes: Option<u64>,
}

impl Quota {
    /// Returns the quota of an owner.
    pub(super) fn of(self, owner: &Owner) -> Self {
        match owner.is_anonymous() {
            true => Self::default(),
            false => self,
        }
    }
}
