//! Short jobs, claimed before a worker is free for them.
//!
//! A shared store takes a millisecond or two to give a job. Where a job lasts for tens of milliseconds, that is some
//! percent of a worker's time, so a process asks for the next jobs while the present ones run. It holds few of them and
//! for moments only, as a job that waits here may keep a worker elsewhere waiting.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::task::TaskTracker;

use super::pool::Shared;
use crate::store::Claim;
use crate::wire::JobId;

/// For so many workers one job may wait.
const WORKERS_EACH: usize = 8;
/// Longest that a job may be expected to wait for its worker, and longest that it does before it is put back.
const EXPECTED_WAIT: Duration = Duration::from_millis(10);
const LONGEST_WAIT: Duration = match cfg!(test) {
    false => Duration::from_millis(100),
    // Something can be done to a job that waits.
    true => Duration::from_secs(3),
};

/// The jobs that wait for a worker of this process.
#[derive(Debug)]
pub struct Ahead {
    workers: usize,
    waiting: Mutex<VecDeque<Waiting>>,
    /// One for each job that waits or was asked for.
    places: Arc<Semaphore>,
    tasks: TaskTracker,
}

#[derive(Debug)]
struct Waiting {
    claim: Claim,
    asked: Instant,
    _place: OwnedSemaphorePermit,
}

impl Ahead {
    /// For so many workers.
    pub fn new(workers: usize) -> Self {
        Self {
            workers,
            waiting: Mutex::default(),
            places: Arc::new(Semaphore::new(places(workers))),
            tasks: TaskTracker::new(),
        }
    }

    /// The job that has waited longest, and when it was asked for.
    pub fn take(&self) -> Option<(Claim, Instant)> {
        let Waiting { claim, asked, .. } = self.lock().pop_front()?;
        Some((claim, asked))
    }

    /// Asks for another job, if one more may wait and a worker can be expected to be free soon. Does not wait for it.
    pub fn ask(&self, shared: &Arc<Shared>) {
        if !self.is_worth_it(shared) {
            return;
        }
        if let Ok(place) = Arc::clone(&self.places).try_acquire_owned() {
            self.tasks.spawn(hold(Arc::clone(shared), place));
        }
    }

    /// Waits until no job waits for a worker any more. Wants the service to be closing, and the workers to have ended.
    pub async fn end(&self) {
        self.tasks.close();
        self.tasks.wait().await;
    }

    fn is_worth_it(&self, shared: &Shared) -> bool {
        let pace = shared.pace();
        let places = places(self.workers) as u32;
        // Where nobody shares the store, it answers at once.
        shared.fence.is_some()
            && !shared.closing.is_cancelled()
            && !pace.is_zero()
            && pace * places <= EXPECTED_WAIT * self.workers as u32
    }

    fn take_back(&self, job: JobId) -> Option<Claim> {
        let mut waiting = self.lock();
        let at = waiting.iter().position(|one| one.claim.lease.job == job)?;
        Some(waiting.remove(at)?.claim)
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Waiting>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How many jobs may wait for so many workers.
fn places(workers: usize) -> usize {
    workers.div_ceil(WORKERS_EACH)
}

/// Claims a job, if one waits, and puts it back if no worker takes it in time.
async fn hold(shared: Arc<Shared>, place: OwnedSemaphorePermit) {
    let asked = Instant::now();
    let claim = match shared.claim().await {
        Ok(Some(claim)) => claim,
        Ok(None) => return,
        // The next worker that is free meets it too, and waits a little.
        Err(error) => return tracing::debug!(%error, "no job can be claimed ahead"),
    };
    let job = claim.lease.job;
    shared.ahead.lock().push_back(Waiting {
        claim,
        asked,
        _place: place,
    });
    shared.queued.notify_one();
    let wait = tokio::time::sleep(LONGEST_WAIT);
    let _ = shared.closing.run_until_cancelled(wait).await;
    if let Some(Claim {
        lease, revision, ..
    }) = shared.ahead.take_back(job)
    {
        tracing::debug!(%job, "no worker was free; the job is put back");
        // What is not put back costs an attempt when its lease ends.
        while !shared.put_back(&lease, revision).await
            && shared.fence.is_some_and(|fence| asked.elapsed() < fence)
            && !shared.stopping.is_cancelled()
        {
            shared.pause().await;
        }
    }
}
