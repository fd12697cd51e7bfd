//! Who waits for news of which job, here and in other processes.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;

use super::herald::Herald;
use crate::wire::{JobId, Progress};

/// Where changes of jobs are told. Nothing is kept of a job that nobody waits for, and of one that
/// somebody does no more than a number.
#[derive(Debug, Default)]
pub struct Changes {
    /// How often the record in the store has changed since somebody began to wait.
    jobs: Mutex<HashMap<JobId, watch::Sender<u64>>>,
    /// Tells other processes; `None` where there are none.
    herald: Option<Herald>,
}

impl Changes {
    /// Those of a process that shares its store with others.
    pub fn shared(herald: Herald) -> Self {
        Self {
            herald: Some(herald),
            ..Self::default()
        }
    }

    /// Hears of every change of a job from here on.
    pub fn subscribe(self: &Arc<Self>, job: JobId) -> Subscription {
        let news = self.lock().entry(job).or_default().subscribe();
        self.ask(job);
        Subscription {
            changes: Arc::clone(self),
            job,
            news,
        }
    }

    /// Lets whoever runs a job know that somebody here waits for news of it.
    pub fn ask(&self, job: JobId) {
        if let Some(herald) = &self.herald {
            herald.follow(job);
        }
    }

    /// The record in the store has changed.
    pub fn stored(&self, job: JobId) {
        self.heard(job);
        if let Some(herald) = &self.herald {
            herald.changed(job);
        }
    }

    /// A job was cancelled or forgotten.
    pub fn stopped(&self, job: JobId) {
        self.heard(job);
        if let Some(herald) = &self.herald {
            herald.stopped(job);
        }
    }

    /// A job was queued.
    pub fn queued(&self) {
        if let Some(herald) = &self.herald {
            herald.queued();
        }
    }

    /// The run has told where it stands; the record in the store is as it was.
    pub fn progressed(&self, job: JobId, revision: u64, progress: &Progress) {
        self.heard_of_run(job);
        if let Some(herald) = &self.herald {
            herald.progressed(job, revision, progress);
        }
    }

    /// Another process has changed the record in the store.
    pub fn heard(&self, job: JobId) {
        if let Some(told) = self.lock().get(&job) {
            told.send_modify(|changes| *changes += 1);
        }
    }

    /// Another process has told where a run stands.
    pub fn heard_of_run(&self, job: JobId) {
        if let Some(told) = self.lock().get(&job) {
            told.send_modify(|_| {});
        }
    }

    /// The jobs that somebody here waits for.
    pub fn followed(&self) -> Vec<JobId> {
        self.lock().keys().copied().collect()
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
        changes.heard_of_run(JobId::new());
        let nothing = tokio::time::timeout(Duration::from_millis(20), one.hear()).await;
        assert!(nothing.is_err(), "what was before is no news");
        changes.heard_of_run(job);
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
