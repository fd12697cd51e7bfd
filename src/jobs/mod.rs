//! The life of a job: submitted, queued, run on the bounded pool, cancelled, recovered.
//!
//! [`Service`] is the one door. Behind it, `intake` turns uploads into meshes, `pool` runs the
//! queue, `running` is how the two meet while a job runs: progress out, the wish to stop in;
//! `webhooks` tells of its end.

mod cache;
mod error;
mod intake;
mod pool;
mod running;
mod service;
#[cfg(test)]
mod tests;
pub mod webhooks;
mod worker;

pub use crate::store::{OpenError, StoreError, Upload};
pub use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId, MeshPage, MeshRecord};
pub use error::{Error, StartError};
pub use intake::IntakeLimits;
pub use pool::Runner;
pub use service::{Options, Service};
