//! What the processes that share a store tell each other, so that nobody has to look all the time.
//!
//! A notice may be lost, late, or told twice. Nothing hangs on it: whoever does not hear one finds the same in
//! the store a little later.

use async_trait::async_trait;
use serde::{Deserialize, Serialize};

use super::StoreError;
use crate::wire::{JobId, Progress};

/// Something that others may want to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Notice {
    /// To workers: jobs wait.
    Queued,
    /// To workers: these jobs were cancelled or forgotten.
    Stopped(Vec<JobId>),
    /// To workers: somebody waits for news of these jobs.
    Followed(Vec<JobId>),
    /// To servers: the records of these jobs have changed, or are gone.
    Changed(Vec<JobId>),
    /// To servers: a run stands so.
    Progress {
        job: JobId,
        revision: u64,
        progress: Progress,
    },
}

/// Which notices are heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Audience {
    pub workers: bool,
    pub servers: bool,
}

/// Telling others who share a store, and hearing them.
#[async_trait]
pub trait Notices {
    /// Tells others.
    async fn tell(&self, notices: &[Notice]) -> Result<(), StoreError>;

    /// Hears what others tell from here on; `None` where there are no others.
    async fn listen(&self, audience: Audience) -> Result<Option<Box<dyn Listener>>, StoreError>;
}

/// One who hears what others tell.
#[async_trait]
pub trait Listener: Send {
    /// The next notices. Fails when the line is broken: what was told meanwhile is lost, and another listener is
    /// needed.
    async fn hear(&mut self) -> Result<Vec<Notice>, StoreError>;
}
