//! The service itself: what it consists of, and its end.

use std::future::Future;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio_util::sync::CancellationToken;
use tracing::Instrument;

use super::job_counts::JobCounts;
use super::slots::Slots;
use crate::jobs::context::Context;
use crate::jobs::error::Error;
use crate::jobs::idempotency::{IdempotencyKey, KeysInUse};
use crate::jobs::options::Quota;
use crate::jobs::owner_limits::OwnerLimits;
use crate::jobs::pool::Pool;
use crate::jobs::webhooks::{AllowedHosts, Sender};
use crate::metrics::{Format, Metrics};
use crate::store::{Owner, SharedStore};

/// Longest time to wait for running jobs at a shutdown.
const LAST_STEPS: Duration = Duration::from_secs(5);

/// Meshes, jobs and batches. Clones are the same service.
///
/// Ids are taken as clients write them; one that cannot be an id names nothing. A change runs to its end even when the
/// caller does not wait for it.
#[derive(Clone)]
pub struct Service(pub(super) Arc<Inner>);

pub(super) struct Inner {
    pub store: SharedStore,
    pub context: Arc<Context>,
    pub pool: Pool,
    pub slots: Slots,
    /// The threads that evaluate grasps.
    pub evaluators: Arc<rayon::ThreadPool>,
    pub followers: OwnerLimits,
    pub keys_in_use: KeysInUse,
    pub limits: Limits,
    pub shutdown: Shutdown,
    /// `None` where another process counts.
    pub job_counts: Option<JobCounts>,
    pub callback_hosts: AllowedHosts,
    /// `None` while webhooks are off.
    pub webhooks: Option<Sender>,
}

/// The limits on what is accepted.
pub(super) struct Limits {
    pub workers: usize,
    pub queue_capacity: u32,
    pub quota: Quota,
    pub min_free_disk: u64,
    /// Least time between two records of the use of a mesh.
    pub mark_used_every: Duration,
}

/// How the service ends.
pub(super) struct Shutdown {
    /// Whether new work is refused.
    pub is_draining: AtomicBool,
    /// How long running jobs may go on.
    pub drain: Duration,
    /// Cuts that short.
    pub hurry: CancellationToken,
}

impl Service {
    /// Returns the owner that an API key stands for, if it is valid.
    pub async fn owner_of(&self, key: &str) -> Result<Option<Owner>, Error> {
        Ok(self.0.store.owner_of(key).await?)
    }

    /// Returns whether any API key is valid.
    pub async fn has_keys(&self) -> Result<bool, Error> {
        Ok(self.0.store.has_keys().await?)
    }

    /// Begins a submission under an idempotency key of 1 to 255 characters. Refused while another one under the same
    /// key is being carried out.
    pub fn begin_submission(&self, owner: &Owner, key: &str) -> Result<IdempotencyKey, Error> {
        self.0.keys_in_use.begin(owner, key)
    }

    /// Returns the metrics.
    pub fn metrics(&self) -> &Metrics {
        &self.0.context.metrics
    }

    /// Writes all metrics as they are now. Takes at most a second or two even when the store does not answer: the
    /// numbers of jobs are left out then.
    pub async fn scrape(&self, format: Format) -> Result<String, std::fmt::Error> {
        if let Some(counts) = &self.0.job_counts {
            counts.refresh(&self.0.store, &self.metrics().jobs).await;
        }
        self.metrics().encode(format)
    }

    /// Refuses new work from here on. Reading, cancelling and deleting go on.
    pub fn begin_drain(&self) {
        let draining = &self.0.shutdown.is_draining;
        draining.store(true, Ordering::Relaxed);
    }

    /// Refuses new work, lets running jobs go on for as long as they may, puts the rest back in the queue without
    /// counting the attempt, and ends the workers; within 5 s beyond that whatever a run does. Webhooks under way have
    /// 3 s, the rest waits for the next start. Reading, cancelling and deleting go on.
    pub async fn shutdown(&self) {
        self.begin_drain();
        let Shutdown { drain, hurry, .. } = &self.0.shutdown;
        self.0.pool.drain(*drain, hurry).await;
        self.stop_workers(LAST_STEPS).await;
        if let Some(webhooks) = &self.0.webhooks {
            webhooks.ended().await;
        }
    }

    /// Cuts short the time that running jobs have when the service shuts down.
    pub fn hurry(&self) {
        self.0.shutdown.hurry.cancel();
    }

    /// Closes the store, once nothing is to be answered any more. Only tidies up: what was acknowledged is safe without
    /// it.
    pub async fn close(&self) {
        self.0.store.close().await;
    }

    /// Puts running jobs back and ends the workers, waiting for `grace` at most.
    pub(in crate::jobs) async fn stop_workers(&self, grace: Duration) {
        self.0.pool.stop(grace).await;
    }

    /// Runs a change in a task of its own, so that it is never cut in half: the caller may be dropped at any moment,
    /// when a client hangs up.
    pub(super) async fn run_detached<T, F>(
        &self,
        change: impl FnOnce(Arc<Inner>) -> F,
    ) -> Result<T, Error>
    where
        T: Send + 'static,
        F: Future<Output = Result<T, Error>> + Send + 'static,
    {
        // The span carries the id of the request into the log lines.
        let change = change(Arc::clone(&self.0)).in_current_span();
        match tokio::spawn(change).await {
            Ok(outcome) => outcome,
            Err(panic) => Err(Error::bug(panic)),
        }
    }
}

impl Inner {
    /// Fails if new work is refused.
    pub fn check_open(&self) -> Result<(), Error> {
        match self.shutdown.is_draining.load(Ordering::Relaxed) {
            true => Err(Error::Draining),
            false => Ok(()),
        }
    }

    /// Fails if the process takes as much memory as it may.
    pub fn check_memory(&self) -> Result<(), Error> {
        match self.context.memory.is_over() {
            true => Err(Error::OutOfMemory),
            false => Ok(()),
        }
    }

    /// Returns what an owner may have.
    pub fn quota(&self, owner: &Owner) -> Quota {
        self.limits.quota.of(owner)
    }
}
