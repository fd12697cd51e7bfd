//! Counts the jobs in the store for the metrics.

use std::time::{Duration, Instant};

use tokio::sync::Mutex;
use tokio::time::timeout;

use crate::metrics::JobMetrics;
use crate::store::{SharedStore, Unfinished};
use crate::wire::{JobId, JobState};

/// Longest time to wait for the store.
const PATIENCE: Duration = Duration::from_secs(1);
/// Shortest time between two counts.
const COUNT_EVERY: Duration = Duration::from_secs(1);
/// Counting the jobs that have ended takes time in proportion to them; at most one part in so many of all time.
const COUNTING_SHARE: u32 = 20;

/// When jobs are counted again.
#[derive(Debug, Default)]
pub struct JobCounts(Mutex<Next>);

#[derive(Debug, Default)]
struct Next {
    unfinished: Option<Instant>,
    ended: Option<Instant>,
}

impl JobCounts {
    /// Counts the jobs in the store, unless that was done just now.
    pub async fn refresh(&self, store: &SharedStore, metrics: &JobMetrics) {
        // Whoever holds the lock counts for all.
        let Ok(mut next) = timeout(PATIENCE, self.0.lock()).await else {
            return;
        };
        let Next { unfinished, ended } = &mut *next;
        tokio::join!(
            count_unfinished(store, metrics, unfinished),
            count_ended(store, metrics, ended)
        );
    }
}

async fn count_unfinished(store: &SharedStore, metrics: &JobMetrics, next: &mut Option<Instant>) {
    if !is_due(*next) {
        return;
    }
    let counted = timeout(PATIENCE, store.unfinished_jobs()).await;
    let counted = counted.ok().and_then(Result::ok);
    let count = |jobs: fn(&Unfinished) -> u64| counted.as_ref().map(jobs);
    metrics.set_jobs(JobState::Queued.name(), count(|counted| counted.queued));
    metrics.set_jobs(JobState::Running.name(), count(|counted| counted.running));
    let waited = |oldest: Option<JobId>| oldest.map_or(Duration::ZERO, |id| id.age());
    metrics.set_oldest(counted.map(|counted| waited(counted.oldest_queued)));
    *next = Instant::now().checked_add(COUNT_EVERY);
}

async fn count_ended(store: &SharedStore, metrics: &JobMetrics, next: &mut Option<Instant>) {
    if !is_due(*next) {
        return;
    }
    let clock = Instant::now();
    let counted = timeout(PATIENCE, store.ended_jobs()).await;
    let counted = counted.ok().and_then(Result::ok);
    for state in JobState::ALL.into_iter().filter(|state| state.is_final()) {
        let jobs = counted.as_ref().map(|counted| {
            let found = counted.iter().find(|(found, _)| *found == state);
            found.map_or(0, |(_, jobs)| *jobs)
        });
        metrics.set_jobs(state.name(), jobs);
    }
    let pause = COUNT_EVERY.max(clock.elapsed() * COUNTING_SHARE);
    *next = Instant::now().checked_add(pause);
}

fn is_due(next: Option<Instant>) -> bool {
    next.is_none_or(|next| next <= Instant::now())
}
