//! The life of a job: submitted, queued, run on the bounded pool, cancelled, recovered.
//!
//! [`Service`] is the one door. Behind it, `intake` turns uploads into meshes, `pool` runs the
//! queue, `control` is how the two meet while a job runs: progress out, the wish to stop in.
//! `changes` tells those who wait, `watchdog` ends what does not end by itself, and `webhooks` tell
//! of the end.

mod cache;
mod changes;
mod control;
mod error;
mod intake;
mod memory;
mod pool;
mod retention;
mod running;
mod service;
mod shares;
mod submission;
#[cfg(test)]
mod tests;
mod watchdog;
pub mod webhooks;
mod worker;

pub use crate::store::{OpenError, Owner, StoreError, Upload};
pub use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId, MeshPage, MeshRecord};
pub use error::{Error, StartError};
pub use intake::IntakeLimits;
pub use pool::Runner;
pub use service::{Follower, Incoming, Options, Service, Share};
pub use submission::Once;
