//! Jobs: submitted, queued, run by a bounded number of workers, cancelled, recovered, deleted.
//!
//! # The life of a job
//!
//! ```text
//!             submit              claim                finish
//!   (client) --------> queued ------------> running ------------> succeeded | failed | cancelled
//!                       |  ^                   |
//!                cancel |  |    release        |
//!                       |  +-------------------+
//!                       |       recover
//!                       v
//!                   cancelled                               delete, expire: from any state to nothing
//! ```
//!
//! * **submit**: a client, through [`Service`]. Once the answer is sent, the job is on stable storage and outlives any
//!   crash.
//! * **claim**: a `worker`, through the `queue`. From here on it holds a lease, and only the holder of
//!   the lease may finish or release the job; [`crate::cluster`] says why no job ends twice.
//! * **finish**: `settle` writes what became of a run, or the `watchdog` does, without
//!   waiting for a run that does not end.
//! * **release**: the run stops although nobody asked for that: the process shuts down, memory is short, the lease
//!   cannot be renewed, a shared store does not deliver the mesh. The job returns to its position in the queue and has
//!   lost no attempt.
//! * **recover**: the holder died. The next start does it for a folder, any other process for a database. This is
//!   what counts attempts: after the last one the job fails.
//! * **cancel**: a client. A queued job ends at once. A running one is only marked in the store, and its run asked to
//!   stop; whoever finishes, releases or recovers it then makes it `cancelled`, with what was found if the run handed
//!   that in.
//!
//! A crash loses what a run has found so far, never a job: its state, settings and mesh are in the store. Progress and
//! its revisions are kept in memory; after a crash the revision jumps beyond all that clients can have seen.
//!
//! # The files
//!
//! [`Service`] is the one entrance. `pool` keeps the worker threads; a `worker` takes a job from the `queue`,
//! `run` plans it, `control` is how a run and the rest of the process meet, `running` lists the runs, and
//! `context` is what they share. `webhooks` notify receivers of the end of a job.

mod context;
mod control;
mod error;
mod idempotency;
mod ingest;
mod lifecycle;
mod memory;
mod mesh_cache;
mod observer;
mod options;
mod owner_limits;
mod pool;
mod queue;
mod retention;
mod run;
mod running;
mod service;
mod settle;
#[cfg(test)]
mod tests;
mod watchdog;
pub mod webhooks;
mod worker;
mod workers;

pub use crate::store::{JobFilter, OpenError, Owner, StoreError, Upload};
pub use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId, MeshPage, MeshRecord};
pub use context::Runner;
pub use error::{Error, StartError};
pub use idempotency::IdempotencyKey;
pub use ingest::IngestLimits;
pub use options::{Location, Options, PlanningOptions, Quota, Role};
pub use service::{Follower, MeshUpload, Service};
