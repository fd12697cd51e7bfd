//! Wakes those in this process who wait for a job, and notifies other processes.

use std::collections::HashMap;
use std::sync::Arc;

use parking_lot::Mutex;
use tokio::sync::{Notify, watch};

use super::coordinator::Coordinator;
use crate::wire::{JobId, Progress};

/// Announces changes of jobs. Keeps a number for each job that is being followed, and nothing for the others.
#[derive(Debug)]
pub struct Changes {
    /// For each job followed here: how often its record in the store has changed since then.
    followed: Mutex<HashMap<JobId, watch::Sender<u64>>>,
    /// Wakes an idle worker.
    queued: Notify,
    coordinator: Arc<dyn Coordinator>,
}

impl Changes {
    /// Nobody follows anything.
    pub fn new(coordinator: Arc<dyn Coordinator>) -> Self {
        Self {
            followed: Mutex::default(),
            queued: Notify::new(),
            coordinator,
        }
    }

    /// Returns the coordinator through which other processes are notified.
    pub fn coordinator(&self) -> &dyn Coordinator {
        &*self.coordinator
    }

    /// Follows a job: the subscription sees every change from here on.
    pub fn subscribe(self: &Arc<Self>, job: JobId) -> Subscription {
        let changed = self.followed.lock().entry(job).or_default().subscribe();
        self.coordinator.request_notices(job);
        Subscription {
            changes: Arc::clone(self),
            job,
            changed,
        }
    }

    /// Returns the jobs that somebody here follows.
    pub fn followed(&self) -> Vec<JobId> {
        self.followed.lock().keys().copied().collect()
    }

    /// Announces that jobs wait, here and elsewhere.
    pub fn announce_queued(&self) {
        self.wake_worker();
        self.coordinator.notify_queued();
    }

    /// Announces that the record of a job in the store has changed.
    pub fn announce_record(&self, job: JobId) {
        self.wake_for_record(job);
        self.coordinator.notify_changed(job);
    }

    /// Announces that a job was cancelled or deleted.
    pub fn announce_stop(&self, job: JobId) {
        self.wake_for_record(job);
        self.coordinator.notify_stopped(job);
    }

    /// Announces the progress of a run; the record in the store is as it was.
    pub fn announce_progress(&self, job: JobId, revision: u64, progress: &Progress) {
        self.wake_for_progress(job);
        self.coordinator.notify_progress(job, revision, progress);
    }

    /// Wakes those here who follow a job: its record in the store may have changed.
    pub fn wake_for_record(&self, job: JobId) {
        if let Some(sender) = self.followed.lock().get(&job) {
            sender.send_modify(|changes| *changes += 1);
        }
    }

    /// Wakes those here who follow a job: its run has made progress.
    pub fn wake_for_progress(&self, job: JobId) {
        if let Some(sender) = self.followed.lock().get(&job) {
            sender.send_modify(|_| {});
        }
    }

    /// Wakes one idle worker of this process; if none is idle, the next one that would be looks again.
    pub fn wake_worker(&self) {
        self.queued.notify_one();
    }

    /// Waits until jobs may be waiting.
    pub async fn until_queued(&self) {
        self.queued.notified().await;
    }
}

/// Follows one job.
#[derive(Debug)]
pub struct Subscription {
    changes: Arc<Changes>,
    job: JobId,
    changed: watch::Receiver<u64>,
}

impl Subscription {
    /// Waits for changes that were not seen; many that came meanwhile count as one.
    pub async fn changed(&mut self) {
        // The sender lives as long as this receiver.
        let _ = self.changed.changed().await;
    }

    /// Returns how often the record in the store has changed.
    pub fn record_changes(&self) -> u64 {
        *self.changed.borrow()
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        let mut followed = self.changes.followed.lock();
        if let Some(sender) = followed.get(&self.job)
            && sender.receiver_count() == 1
        {
            followed.remove(&self.job);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::super::coordinator::LocalCoordinator;
    use super::*;

    #[tokio::test]
    async fn changes_are_seen_once_and_nothing_is_kept_for_nobody() {
        let changes = Arc::new(Changes::new(Arc::new(LocalCoordinator)));
        let job = JobId::new();
        changes.announce_record(job);
        assert!(changes.followed.lock().is_empty());
        let mut one = changes.subscribe(job);
        let two = changes.subscribe(job);
        changes.wake_for_progress(JobId::new());
        let nothing = tokio::time::timeout(Duration::from_millis(20), one.changed()).await;
        assert!(nothing.is_err(), "what was before is no change");
        changes.wake_for_progress(job);
        changes.announce_record(job);
        changes.announce_record(job);
        one.changed().await;
        assert_eq!(one.record_changes(), 2);
        let nothing = tokio::time::timeout(Duration::from_millis(20), one.changed()).await;
        assert!(nothing.is_err(), "all of it was seen");
        drop(one);
        assert_eq!(changes.followed.lock().len(), 1);
        drop(two);
        assert!(changes.followed.lock().is_empty());
    }
}
