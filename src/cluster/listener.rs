//! Receives the notices of other processes, and polls the store for what they did not deliver.
//!
//! A notice may be lost, late or doubled: nothing depends on it. Polling alone would do, a second late.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use tokio::time::sleep;
use tokio_util::sync::CancellationToken;

use super::changes::Changes;
use super::coordinator::Coordinator;
use super::jitter::jittered;
use super::lease::HeldLease;
use super::shared::SharedCoordinator;
use crate::store::{self, Audience, Notice, SharedStore};
use crate::wire::JobId;

/// Time between two polls for changes of jobs that somebody here follows.
const POLL_EVERY: Duration = Duration::from_secs(1);
/// Longest time that a queued job waits for an idle worker whose notice was lost.
const QUEUE_EVERY: Duration = Duration::from_secs(2);
/// Pause before a broken connection is opened again.
const RECONNECT_PAUSE: Duration = Duration::from_secs(1);

/// Follows the other processes on behalf of this one.
pub struct Listener<F> {
    pub store: SharedStore,
    pub coordinator: Arc<SharedCoordinator>,
    pub changes: Arc<Changes>,
    /// Returns the lease of a job that runs here.
    pub lease_of: F,
    pub stopping: CancellationToken,
}

impl<F: Fn(JobId) -> Option<Arc<HeldLease>> + Send + Sync + 'static> Listener<F> {
    /// Starts receiving and polling, until the process stops.
    pub fn start(self, audience: Audience) {
        let listener = Arc::new(self);
        let receiver = Arc::clone(&listener);
        tokio::spawn(async move {
            let stopping = receiver.stopping.clone();
            stopping
                .run_until_cancelled(receiver.receive(audience))
                .await;
        });
        tokio::spawn(async move {
            let stopping = listener.stopping.clone();
            stopping.run_until_cancelled(listener.poll()).await;
        });
    }

    /// Receives notices over one connection after the other.
    async fn receive(&self, audience: Audience) {
        loop {
            match self.store.listen(audience).await {
                Ok(Some(connection)) => {
                    // The notices before the connection are lost.
                    self.catch_up();
                    self.receive_from(connection).await;
                }
                Ok(None) => return,
                Err(error) => tracing::debug!(%error, "notices cannot be received"),
            }
            sleep(RECONNECT_PAUSE).await;
        }
    }

    async fn receive_from(&self, mut connection: Box<dyn store::Listener>) {
        loop {
            match connection.receive().await {
                Ok(notices) => {
                    for notice in notices {
                        self.handle(notice);
                    }
                }
                Err(error) => {
                    return tracing::warn!(%error, "the connection for notices is broken");
                }
            }
        }
    }

    fn handle(&self, notice: Notice) {
        match notice {
            Notice::Queued => self.changes.wake_worker(),
            Notice::Followed(jobs) => self.coordinator.notifier().add_followed_elsewhere(&jobs),
            Notice::Changed(jobs) => {
                for job in jobs {
                    self.coordinator.forget_progress(job);
                    self.changes.wake_for_record(job);
                }
            }
            Notice::Progress {
                job,
                revision,
                progress,
            } => {
                self.coordinator.remember_progress(job, revision, progress);
                self.changes.wake_for_progress(job);
            }
            Notice::Stopped(jobs) => jobs.into_iter().for_each(|job| self.stop(job)),
        }
    }

    /// Looks whether the run of a job has to stop, if it is here.
    fn stop(&self, job: JobId) {
        // In this order: a worker enters its run first, and then asks whether the job may have been stopped.
        self.coordinator.remember_stop(job);
        if let Some(held) = (self.lease_of)(job) {
            let store = Arc::clone(&self.store);
            tokio::spawn(async move { held.check(&store).await });
        }
    }

    /// Handles every notice that may have been lost as if it had arrived.
    fn catch_up(&self) {
        self.changes.wake_worker();
        for job in self.changes.followed() {
            self.changes.wake_for_record(job);
        }
    }

    /// Polls the store.
    async fn poll(&self) {
        let mut known: HashMap<JobId, u64> = HashMap::new();
        let mut queue_in = QUEUE_EVERY;
        loop {
            let pause = jittered(POLL_EVERY, 0.75..1.25);
            sleep(pause).await;
            queue_in = match queue_in.checked_sub(pause) {
                Some(left) => left,
                None => {
                    self.changes.wake_worker();
                    QUEUE_EVERY
                }
            };
            let mut followed = self.changes.followed();
            followed.retain(|job| (self.lease_of)(*job).is_none());
            for job in &followed {
                self.coordinator.request_notices(*job);
            }
            self.compare(&followed, &mut known).await;
            self.coordinator.forget_old();
        }
    }

    /// Wakes those who follow one of these jobs whose revision is not the `known` one.
    async fn compare(&self, jobs: &[JobId], known: &mut HashMap<JobId, u64>) {
        if jobs.is_empty() {
            return known.clear();
        }
        let revisions = match self.store.revisions(jobs).await {
            Ok(revisions) => revisions,
            Err(error) => {
                return tracing::debug!(%error, "the store cannot be polled for changes");
            }
        };
        let before = std::mem::replace(known, revisions.into_iter().collect());
        for job in jobs {
            if before.get(job) != known.get(job) {
                self.changes.wake_for_record(*job);
            }
        }
    }
}
