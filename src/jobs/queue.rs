//! The queue, as the workers of this process see it: the next job, and back with one that was not run.
//!
//! The queue itself is in the store, which decides whose turn it is. Here are the rules of this process: every fourth
//! claim prefers the jobs that nobody waits for (so interactive jobs cannot starve them), and on a shared store the
//! next short jobs are claimed in advance.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use tokio::sync::OwnedSemaphorePermit;
use tokio_util::task::TaskTracker;

use super::lifecycle::Lifecycle;
use super::memory::Memory;
use crate::cluster::{Changes, Prefetch, TimedClaim};
use crate::store::{Lease, SharedStore, StoreError};
use crate::wire::Priority;

/// Every fourth claim prefers the jobs that nobody waits for.
const BATCH_EVERY: u32 = 4;

/// Claims jobs and puts them back.
pub struct Queue {
    store: SharedStore,
    changes: Arc<Changes>,
    lifecycle: Lifecycle,
    /// Claims so far, by which the priorities take turns.
    claims: AtomicU32,
    /// Moving average of the time that a job takes, in microseconds.
    pace: AtomicU64,
    /// `None` where the store is not shared: it answers at once.
    prefetch: Option<Prefetch>,
    prefetching: TaskTracker,
}

impl Queue {
    /// The queue for so many workers.
    pub fn new(
        store: SharedStore,
        changes: Arc<Changes>,
        lifecycle: Lifecycle,
        workers: usize,
    ) -> Self {
        let is_shared = changes.coordinator().is_shared();
        Self {
            store,
            changes,
            lifecycle,
            claims: AtomicU32::new(0),
            pace: AtomicU64::new(0),
            prefetch: is_shared.then(|| Prefetch::new(workers)),
            prefetching: TaskTracker::new(),
        }
    }

    /// Waits for the next job; `None` when no job is begun any more.
    pub async fn next(self: &Arc<Self>, memory: &Memory) -> Option<TimedClaim> {
        let closing = &self.lifecycle.closing;
        while !closing.is_cancelled() {
            // A job that starts now would be the first to be stopped.
            if memory.is_over() {
                self.lifecycle.store_pause().await;
                continue;
            }
            match self.take_or_claim().await {
                Ok(Some(claim)) => {
                    // However many jobs came, one wake-up is remembered; pass it on.
                    self.changes.wake_worker();
                    self.prefetch();
                    return Some(claim);
                }
                Ok(None) => {
                    let _ = closing
                        .run_until_cancelled(self.changes.until_queued())
                        .await;
                }
                Err(error) => {
                    tracing::error!(%error, "the queue cannot be read");
                    self.lifecycle.store_pause().await;
                }
            }
        }
        None
    }

    /// Puts a job back that is not run, at the revision that clients have seen. Returns whether the store has answered.
    pub async fn put_back(&self, lease: &Lease, revision: u64) -> bool {
        let job = lease.job;
        if let Err(error) = self.store.release(lease, revision).await {
            tracing::error!(%job, %error, "a job cannot be put back; another process or the next start does it");
            return false;
        }
        self.changes.announce_queued();
        self.changes.announce_record(job);
        true
    }

    /// Returns how long a job takes, judging by the last ones; zero when none has ended.
    pub fn pace(&self) -> Duration {
        Duration::from_micros(self.pace.load(Ordering::Relaxed))
    }

    /// Takes the duration of a job into the average.
    pub fn note_pace(&self, took: Duration) {
        let took = u64::try_from(took.as_micros()).unwrap_or(u64::MAX);
        // Two workers may lose each other's update: it is an estimate.
        let pace = match self.pace.load(Ordering::Relaxed) {
            0 => took,
            pace => pace - pace / 8 + took / 8,
        };
        self.pace.store(pace, Ordering::Relaxed);
    }

    /// Waits until no job waits for a worker any more. Call it when no job is begun any more and the workers have ended.
    pub async fn end(&self) {
        self.prefetching.close();
        self.prefetching.wait().await;
    }

    async fn take_or_claim(&self) -> Result<Option<TimedClaim>, StoreError> {
        match self.prefetch.as_ref().and_then(Prefetch::take) {
            Some(claim) => Ok(Some(claim)),
            None => self.claim().await,
        }
    }

    /// Claims the next job, of the priority whose turn it is if one waits.
    async fn claim(&self) -> Result<Option<TimedClaim>, StoreError> {
        let turn = self.claims.fetch_add(1, Ordering::Relaxed);
        let first = match turn % BATCH_EVERY {
            0 => Priority::Batch,
            _ => Priority::Interactive,
        };
        let asked = Instant::now();
        let claim = self.store.claim(first).await?;
        Ok(claim.map(|claim| TimedClaim { claim, asked }))
    }

    /// Starts to claim one more job in the background, if that is worth it.
    fn prefetch(self: &Arc<Self>) {
        if let Some(prefetch) = &self.prefetch
            && !self.lifecycle.closing.is_cancelled()
            && let Some(slot) = prefetch.reserve(self.pace())
        {
            self.prefetching.spawn(Arc::clone(self).hold(slot));
        }
    }

    /// Claims a job, and puts it back if no worker takes it in time.
    async fn hold(self: Arc<Self>, slot: OwnedSemaphorePermit) {
        let Some(prefetch) = &self.prefetch else {
            return;
        };
        let claim = match self.claim().await {
            Ok(Some(claim)) => claim,
            Ok(None) => return,
            // The next worker that is free meets it too, and pauses.
            Err(error) => return tracing::debug!(%error, "no job can be prefetched"),
        };
        let job = claim.claim.lease.job;
        prefetch.push(claim, slot);
        self.changes.wake_worker();
        let wait = tokio::time::sleep(Prefetch::LONGEST_WAIT);
        let _ = self.lifecycle.closing.run_until_cancelled(wait).await;
        let Some(TimedClaim { claim, asked }) = prefetch.take_back(job) else {
            return;
        };
        tracing::debug!(%job, "no worker was free for a prefetched job; it is put back");
        // A job that is not put back costs an attempt when its lease expires.
        let fence = self.changes.coordinator().fence();
        while !self.put_back(&claim.lease, claim.revision).await
            && fence.is_some_and(|fence| asked.elapsed() < fence)
            && !self.lifecycle.stopping.is_cancelled()
        {
            self.lifecycle.store_pause().await;
        }
    }
}
