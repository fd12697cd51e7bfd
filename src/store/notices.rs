//! Notices that the processes which share a store send each other, so that none has to poll the store all the time.
//!
//! A notice may be lost, late, or sent twice. Nothing depends on it: a process that does not receive one finds the same
//! in the store a little later.

use async_trait::async_trait;
use serde::{Deserialize, Serialize};

use super::StoreError;
use crate::wire::{JobId, Progress};

/// News for the other processes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Notice {
    /// To workers: jobs wait.
    Queued,
    /// To workers: these jobs were cancelled or forgotten.
    Stopped(Vec<JobId>),
    /// To workers: a client follows these jobs.
    Followed(Vec<JobId>),
    /// To servers: the records of these jobs have changed, or are gone.
    Changed(Vec<JobId>),
    /// To servers: the progress of a run.
    Progress {
        job: JobId,
        revision: u64,
        progress: Progress,
    },
}

/// Which notices a process receives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Audience {
    pub workers: bool,
    pub servers: bool,
}

/// The notices of a store.
#[async_trait]
pub trait Notices {
    /// Sends notices to the other processes.
    async fn notify(&self, notices: &[Notice]) -> Result<(), StoreError>;

    /// Receives the notices of other processes from now on; `None` where there are no others.
    async fn listen(&self, audience: Audience) -> Result<Option<Box<dyn Listener>>, StoreError>;
}

/// Receives the notices of other processes.
#[async_trait]
pub trait Listener: Send {
    /// Waits for the next notices. Fails when the connection is broken: what is sent meanwhile is lost, and another
    /// listener is needed.
    async fn receive(&mut self) -> Result<Vec<Notice>, StoreError>;
}
