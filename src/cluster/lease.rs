//! The right to write about a running job.
//!
//! # The protocol
//!
//! ```text
//! claim:    queued  -> running, with a fresh token; leased until now + T        (T = lease time)
//! renew:    running, token and attempt as claimed -> leased until now + T
//! finish:   running, token and attempt as claimed -> succeeded | failed | cancelled
//! release:  running, token and attempt as claimed -> queued (or cancelled, if that was requested)
//! recover:  running, leased until a moment in the past -> queued with the next attempt,
//!           or failed after the last one, or cancelled
//! ```
//!
//! Each line is one atomic statement of the store; "now" is the clock of the database, so the clocks of the processes
//! do not matter. A folder has one process: its leases do not expire, and `recover` runs once, at the start.
//!
//! # Invariants
//!
//! * A job in the state `running` has exactly one token, and only its holder knows it. The other states have none.
//! * Every write of a holder names job, attempt and token, and changes nothing unless all three still match. So of
//!   all who ever held a job at most one ends it: a second end finds no token, however late it comes.
//! * An attempt is counted only by `recover`: a job put back by its holder has lost nothing.
//!
//! # Fence
//!
//! Correctness does not depend on a holder noticing that its lease has expired; economy does. A holder that could not
//! renew its lease for `fence` = 0.8 T, on its own monotonic clock, stops its run. It counts from the moment before it
//! *sent* its last successful renewal, which is earlier than the moment from which the database counts; so the run
//! stops before another process may begin the same job, unless the process was halted altogether.
//!
//! # Why every job ends
//!
//! A holder that lives ends or releases its job, or stops renewing it; a holder that does not renew loses the job to
//! `recover` after T; and `recover` gives a job out at most `max_attempts` times.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use parking_lot::Mutex;

use crate::store::{Lease, LeaseStatus, Renewal, SharedStore};
use crate::wire::Progress;
use graspd_core::search::Phase;

/// The part of the lease time after which a run that could not renew its lease stops.
const FENCE: f64 = 0.8;

/// Returns how long after the last renewal a run has to stop.
pub fn fence(lease_time: Duration) -> Duration {
    lease_time.mul_f64(FENCE)
}

/// Why a run has to stop before its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunStop {
    /// The job was cancelled: what was found is kept.
    Cancel,
    /// The job was deleted, ended otherwise, or is in other hands: what was found is of no use.
    Discard,
    /// The process stops or cannot keep its lease: the job runs again from its start.
    Release,
}

/// A lease of this process, with what is written when it is renewed and what the store answers to that.
#[derive(Debug)]
pub struct HeldLease {
    pub lease: Lease,
    /// When the run was entered.
    pub entered: Instant,
    /// When the last renewal that succeeded, or else the claim, was sent.
    renewed: Mutex<Instant>,
    /// The first request to stop, and when it was made.
    stop: OnceLock<(RunStop, Instant)>,
    published: Mutex<Published>,
}

/// The state of a run that clients see between two writes to the store.
#[derive(Debug)]
struct Published {
    revision: u64,
    progress: Progress,
    /// Whether the end of the job is being written, after which nothing more is published.
    is_closed: bool,
}

impl HeldLease {
    /// A lease just claimed; the claim was sent at `asked` and left the record of the job at `revision`.
    pub fn new(lease: Lease, asked: Instant, revision: u64, progress: Progress) -> Self {
        Self {
            lease,
            entered: Instant::now(),
            renewed: Mutex::new(asked),
            stop: OnceLock::new(),
            published: Mutex::new(Published {
                revision,
                progress,
                is_closed: false,
            }),
        }
    }

    /// Requests that the run stops. The first request stands.
    pub fn request_stop(&self, reason: RunStop) {
        let _ = self.stop.set((reason, Instant::now()));
    }

    /// Returns why the run has to stop, if it has to.
    pub fn stop_reason(&self) -> Option<RunStop> {
        self.stop.get().map(|(reason, _)| *reason)
    }

    /// Returns how long ago the run was asked to stop for this reason, if it was.
    pub fn stopping_for(&self, reason: RunStop) -> Option<Duration> {
        let (first, at) = self.stop.get()?;
        (*first == reason).then(|| at.elapsed())
    }

    /// Takes up what the store says about the lease.
    pub fn obey(&self, status: LeaseStatus) {
        match status {
            LeaseStatus::Held => {}
            LeaseStatus::Cancelled => self.request_stop(RunStop::Cancel),
            LeaseStatus::Lost => self.request_stop(RunStop::Discard),
        }
    }

    /// Asks the store whether the run may go on.
    pub async fn check(&self, store: &SharedStore) {
        match store.lease_status(&self.lease).await {
            Ok(status) => self.obey(status),
            Err(error) => {
                tracing::warn!(%error, "the store does not say whether a job was cancelled")
            }
        }
    }

    /// Takes up the answer to a renewal that was sent at `asked`.
    pub fn renewed(&self, asked: Instant, status: LeaseStatus) {
        if status != LeaseStatus::Lost {
            *self.renewed.lock() = asked;
        }
        self.obey(status);
    }

    /// Returns the time since the last renewal.
    pub fn since_renewal(&self) -> Duration {
        self.renewed.lock().elapsed()
    }

    /// Returns what a renewal writes.
    pub fn renewal(&self) -> Renewal {
        let (revision, progress) = self.published();
        Renewal {
            lease: self.lease.clone(),
            revision,
            progress,
        }
    }

    /// Returns the revision and the progress that clients see; the two belong together.
    pub fn published(&self) -> (u64, Progress) {
        let published = self.published.lock();
        let (revision, mut progress) = (published.revision, published.progress.clone());
        drop(published);
        if progress.phase == Phase::Preparing {
            // Nobody reports while a mesh is prepared.
            progress.elapsed_s = self.entered.elapsed().as_secs_f64();
        }
        (revision, progress)
    }

    /// Publishes progress under the next revision and returns both, unless the end of the job is being written.
    pub fn publish(&self, progress: &Progress) -> Option<(u64, Progress)> {
        let mut published = self.published.lock();
        if published.is_closed {
            return None;
        }
        published.revision += 1;
        published.progress = progress.clone();
        // The planner counts from its own start; the time must not jump back after preparing.
        published.progress.elapsed_s = self.entered.elapsed().as_secs_f64();
        Some((published.revision, published.progress.clone()))
    }

    /// Publishes nothing from here on. Returns the last revision that clients may have seen and its progress, with
    /// which the end of the job is written; the contacts are left to the result.
    pub fn close(&self) -> (u64, Progress) {
        self.published.lock().is_closed = true;
        let (revision, progress) = self.published();
        let progress = Progress {
            best_contacts: None,
            ..progress
        };
        (revision, progress)
    }

    /// Makes the next revision greater than that of the record in the store, which has changed.
    pub fn skip_to(&self, revision: u64) {
        let mut published = self.published.lock();
        published.revision = published.revision.max(revision);
    }
}
