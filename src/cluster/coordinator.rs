//! The interface for everything that differs between a process that owns its store and one that shares it.

use std::fmt::Debug;
use std::time::Duration;

use crate::wire::{JobId, Progress};

/// How a process works together with the others that use its store.
///
/// All methods return at once: notices are sent in the background, and may be lost. The defaults are those of a
/// process that has its store for itself.
pub trait Coordinator: Debug + Send + Sync {
    /// How long after its last renewal a lease must not be relied on; `None` where leases last as long as the process.
    fn fence(&self) -> Option<Duration> {
        None
    }

    /// Whether other processes may use the store.
    fn is_shared(&self) -> bool {
        self.fence().is_some()
    }

    /// Notifies the workers of other processes that jobs wait.
    fn notify_queued(&self) {}

    /// Notifies other processes that a job was cancelled or deleted.
    fn notify_stopped(&self, _job: JobId) {}

    /// Notifies those who follow a job elsewhere that its record has changed.
    fn notify_changed(&self, _job: JobId) {}

    /// Sends the progress of a run to those who follow its job elsewhere.
    fn notify_progress(&self, _job: JobId, _revision: u64, _progress: &Progress) {}

    /// Asks the process that runs a job for its notices.
    fn request_notices(&self, _job: JobId) {}

    /// Returns the last progress received of a run in another process, with the revision of the job.
    fn remote_progress(&self, _job: JobId) -> Option<(u64, Progress)> {
        None
    }

    /// Remembers for a moment that a job was cancelled or deleted, as a worker here may be about to enter it.
    fn remember_stop(&self, _job: JobId) {}

    /// Whether a job may have been cancelled or deleted between its claim and the start of its run. Only the store
    /// knows for sure; `false` spares the question.
    fn may_be_stopped(&self, _job: JobId) -> bool {
        true
    }
}

/// The coordinator of a process that has its store for itself.
#[derive(Debug)]
pub struct LocalCoordinator;

impl Coordinator for LocalCoordinator {}
