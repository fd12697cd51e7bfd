//! The processes that work on the jobs of one store.
//!
//! A store is either a folder, which one process has for itself, or a database, which any number of servers and
//! workers share. [`Coordinator`] is all that the rest of the program sees of the difference; [`LocalCoordinator`] and
//! [`SharedCoordinator`] are its two implementations.
//!
//! On a shared database the store alone decides: who runs a job, how it ends, whether it was cancelled. It is never
//! wrong to know nothing of the other processes, only slow. What this module adds is speed and survival:
//!
//! * `lease`: the right to write about a job, the protocol behind it, and why no job ends twice.
//! * `lease_renewal`: keeps the leases of the runs of this process, and recovers the jobs of processes that died.
//! * `notifier` sends notices to the other processes, `listener` receives theirs, and polls the store for what
//!   was lost on the way: a notice is a hint, never a fact.
//! * `changes` wakes whoever in this process waits for a job, whether the change was made here or elsewhere.
//! * `prefetch` holds short jobs that were claimed before a worker is free.

mod changes;
mod coordinator;
mod jitter;
mod lease;
mod lease_renewal;
mod listener;
mod notifier;
mod prefetch;
mod shared;

pub use changes::{Changes, Subscription};
pub use coordinator::{Coordinator, LocalCoordinator};
pub use jitter::jittered;
pub use lease::{HeldLease, RunStop, fence};
pub use lease_renewal::LeaseRenewal;
pub use listener::Listener;
pub use notifier::Notifier;
pub use prefetch::{Prefetch, TimedClaim};
pub use shared::SharedCoordinator;
