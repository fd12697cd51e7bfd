//! The life of a job: submitted, queued, run on the bounded pool, cancelled, recovered.
//!
//! [`Service`] is the one door. Behind it, `intake` turns uploads into meshes, `pool` runs the
//! queue, `control` is how the two meet while a job runs: progress out, the wish to stop in.
//! `changes` tells those who wait, `watchdog` ends what does not end by itself, and `webhooks` tell
//! of the end.
//!
//! Where other processes share the store, `pulse` keeps the leases of what runs here and takes up what the dead
//! held, `herald` tells the others, and `lookout` hears them and looks for what it did not hear.

mod ahead;
mod changes;
mod control;
mod error;
mod herald;
mod idempotency;
mod ingest;
mod lookout;
mod memory;
mod mesh_cache;
mod owner_limits;
mod pool;
mod pulse;
mod retention;
mod running;
mod service;
#[cfg(test)]
mod tests;
mod watchdog;
pub mod webhooks;
mod worker;

pub use crate::store::{JobFilter, OpenError, Owner, StoreError, Upload};
pub use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId, MeshPage, MeshRecord};
pub use error::{Error, StartError};
pub use idempotency::IdempotencyKey;
pub use ingest::IngestLimits;
pub use pool::Runner;
pub use service::{Follower, Location, MeshUpload, Options, Quota, Role, Service};

/// A random number from 0 to 1, for what is not to happen everywhere at the same moment.
fn random() -> f64 {
    f64::from(uuid::Uuid::new_v4().as_u128() as u32) / f64::from(u32::MAX)
}
