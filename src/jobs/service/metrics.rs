//! The numbers of the service.

use std::fmt;
use std::time::{Duration, Instant};

use tokio::time::timeout;

use super::{Inner, Role, Service};
use crate::metrics::{Format, Metrics};
use crate::store::Unfinished;
use crate::wire::{JobId, JobState};

/// Longest that the store is waited for.
const PATIENCE: Duration = Duration::from_secs(1);
/// Shortest time between two counts.
const COUNT_EVERY: Duration = Duration::from_secs(1);
/// Counting those that have ended may take time in proportion to them: of all time one part in so many.
const COUNTING_SHARE: u32 = 20;

/// When jobs are to be counted again.
#[derive(Debug, Default)]
pub struct NextCounts {
    unfinished: Option<Instant>,
    ended: Option<Instant>,
}

impl Service {
    /// What is counted and measured.
    pub fn metrics(&self) -> &Metrics {
        &self.0.shared.metrics
    }

    /// All numbers as they stand. Answers within a second or two even when the store does not: the numbers of jobs
    /// that it does not tell are left out then.
    pub async fn scrape(&self, format: Format) -> Result<String, fmt::Error> {
        self.0.count_jobs().await;
        self.metrics().encode(format)
    }
}

impl Inner {
    /// Counts the jobs in the store, unless that was done just now.
    async fn count_jobs(&self) {
        // One server's answer is enough: counting is not for every process that shares the store.
        if self.role == Role::Worker {
            return;
        }
        // Whoever has it counts for all.
        let Ok(mut next) = timeout(PATIENCE, self.next_counts.lock()).await else {
            return;
        };
        let NextCounts { unfinished, ended } = &mut *next;
        tokio::join!(self.count_unfinished(unfinished), self.count_ended(ended));
    }

    async fn count_unfinished(&self, next: &mut Option<Instant>) {
        if !is_due(*next) {
            return;
        }
        let counted = timeout(PATIENCE, self.store.unfinished_jobs()).await;
        let counted = counted.ok().and_then(Result::ok);
        let numbers = &self.shared.metrics.jobs;
        let of = |jobs: fn(&Unfinished) -> u64| counted.as_ref().map(jobs);
        numbers.set_jobs(JobState::Queued.name(), of(|counted| counted.queued));
        numbers.set_jobs(JobState::Running.name(), of(|counted| counted.running));
        let waited = |oldest: Option<JobId>| oldest.map_or(Duration::ZERO, |id| id.age());
        numbers.set_oldest(counted.map(|counted| waited(counted.oldest_queued)));
        *next = Instant::now().checked_add(COUNT_EVERY);
    }

    async fn count_ended(&self, next: &mut Option<Instant>) {
        if !is_due(*next) {
            return;
        }
        let clock = Instant::now();
        let counted = timeout(PATIENCE, self.store.ended_jobs()).await;
        let counted = counted.ok().and_then(Result::ok);
        for state in JobState::ALL.into_iter().filter(|state| state.is_final()) {
            let jobs = counted.as_ref().map(|counted| {
                let found = counted.iter().find(|(found, _)| *found == state);
                found.map_or(0, |(_, jobs)| *jobs)
            });
            self.shared.metrics.jobs.set_jobs(state.name(), jobs);
        }
        let pause = COUNT_EVERY.max(clock.elapsed() * COUNTING_SHARE);
        *next = Instant::now().checked_add(pause);
    }
}

fn is_due(next: Option<Instant>) -> bool {
    next.is_none_or(|next| next <= Instant::now())
}
