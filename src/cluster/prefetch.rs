//! Short jobs, claimed before a worker is free for them.
//!
//! A shared store takes a millisecond or two to hand out a job. Where jobs last tens of milliseconds, that is some
//! percent of a worker's time, so a process asks for the next jobs while the present ones run. It holds few of them,
//! and only for moments: a job that waits here may keep a worker of another process waiting.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::store::Claim;
use crate::wire::JobId;

/// Workers for each job that may wait.
const WORKERS_PER_JOB: usize = 8;
/// Longest expected wait of a claimed job for a worker.
const EXPECTED_WAIT: Duration = Duration::from_millis(10);

/// A claim, and the moment before it was sent: from there on its lease counts.
#[derive(Debug)]
pub struct TimedClaim {
    pub claim: Claim,
    pub asked: Instant,
}

/// The jobs that wait for a worker of this process.
#[derive(Debug)]
pub struct Prefetch {
    workers: usize,
    waiting: Mutex<VecDeque<Waiting>>,
    /// One permit for each job that waits or is being claimed.
    slots: Arc<Semaphore>,
}

#[derive(Debug)]
struct Waiting {
    claim: TimedClaim,
    _slot: OwnedSemaphorePermit,
}

impl Prefetch {
    /// Longest time that a claimed job waits for a worker before it goes back to the queue.
    pub const LONGEST_WAIT: Duration = match cfg!(test) {
        false => Duration::from_millis(100),
        // Time for a test to cancel a job that waits.
        true => Duration::from_secs(3),
    };

    /// An empty buffer for a process with so many workers.
    pub fn new(workers: usize) -> Self {
        Self {
            workers,
            waiting: Mutex::default(),
            slots: Arc::new(Semaphore::new(slots(workers))),
        }
    }

    /// Returns a slot for one more job, if one is free and a worker can be expected soon. `pace` is the time that a job
    /// takes; zero while that is unknown.
    pub fn reserve(&self, pace: Duration) -> Option<OwnedSemaphorePermit> {
        let is_short = pace * slots(self.workers) as u32 <= EXPECTED_WAIT * self.workers as u32;
        match !pace.is_zero() && is_short {
            true => Arc::clone(&self.slots).try_acquire_owned().ok(),
            false => None,
        }
    }

    /// Adds a claimed job.
    pub fn push(&self, claim: TimedClaim, slot: OwnedSemaphorePermit) {
        let waiting = Waiting { claim, _slot: slot };
        self.waiting.lock().push_back(waiting);
    }

    /// Takes the job that has waited longest.
    pub fn take(&self) -> Option<TimedClaim> {
        Some(self.waiting.lock().pop_front()?.claim)
    }

    /// Takes this job, if no worker has.
    pub fn take_back(&self, job: JobId) -> Option<TimedClaim> {
        let mut waiting = self.waiting.lock();
        let is_it = |one: &Waiting| one.claim.claim.lease.job == job;
        let at = waiting.iter().position(is_it)?;
        Some(waiting.remove(at)?.claim)
    }
}

/// Returns how many jobs may wait for so many workers.
fn slots(workers: usize) -> usize {
    workers.div_ceil(WORKERS_PER_JOB)
}
