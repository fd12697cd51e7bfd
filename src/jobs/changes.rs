//! Who waits for news of which job.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;

use crate::wire::JobId;

/// Where changes of jobs are told. Nothing is kept of a job that nobody waits for, and of one that
/// somebody does no more than a number.
#[derive(Debug, Default)]
pub struct Changes {
    /// How often the record in the store has changed since somebody began to wait.
    jobs: Mutex<HashMap<JobId, watch::Sender<u64>>>,
}

impl Changes {
    /// Hears of every change of a job from here on.
    pub fn subscribe(self: &Arc<Self>, job: JobId) -> Subscription {
        let news = self.lock().entry(job).or_default().subscribe();
        Subscription {
            changes: Arc::clone(self),
            job,
            news,
        }
    }

    /// The record in the store has changed, or is gone.
    pub fn stored(&self, job: JobId) {
        if let Some(told) = self.lock().get(&job) {
            told.send_modify(|changes| *changes += 1);
        }
    }

    /// The run has told where it stands; the record in the store is as it was.
    pub fn progressed(&self, job: JobId) {
        if let Some(told) = self.lock().get(&job) {
            told.send_modify(|_| {});
        }
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<JobId, watch::Sender<u64>>> {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One who waits for news of a job.
#[derive(Debug)]
pub struct Subscription {
    changes: Arc<Changes>,
    job: JobId,
    news: watch::Receiver<u64>,
}

impl Subscription {
    /// Waits for news that have not been heard; many that came meanwhile are heard as one.
    pub async fn hear(&mut self) {
        // The sender is there for as long as this receiver.
        let _ = self.news.changed().await;
    }

    /// How often the record in the store has changed.
    pub fn stored(&self) -> u64 {
        *self.news.borrow()
    }
}

impl Drop for Subscription {
    fn drop(&mut self) {
        let mut jobs = self.changes.lock();
        if let Some(told) = jobs.get(&self.job)
            && told.receiver_count() == 1
        {
            jobs.remove(&self.job);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[tokio::test]
    async fn news_are_heard_once_and_nothing_is_kept_for_nobody() {
        let changes = Arc::new(Changes::default());
        let job = JobId::new();
        changes.stored(job);
        assert!(changes.lock().is_empty());
        let mut one = changes.subscribe(job);
        let two = changes.subscribe(job);
        changes.progressed(JobId::new());
        let nothing = tokio::time::timeout(Duration::from_millis(20), one.hear()).await;
        assert!(nothing.is_err(), "what was before is no news");
        changes.progressed(job);
        changes.stored(job);
        changes.stored(job);
        one.hear().await;
        assert_eq!(one.stored(), 2);
        let nothing = tokio::time::timeout(Duration::from_millis(20), one.hear()).await;
        assert!(nothing.is_err(), "all of it was heard");
        drop(one);
        assert_eq!(changes.lock().len(), 1);
        drop(two);
        assert!(changes.lock().is_empty());
    }
}
