//! The numbers of the service.

use std::fmt;
use std::time::{Duration, Instant};

use super::{Inner, Role, Service};
use crate::metrics::{Format, Metrics};
use crate::wire::JobState;

/// Longest that the store is waited for.
const PATIENCE: Duration = Duration::from_secs(1);
/// How old the numbers of jobs in each state may be: counting them takes time in proportion to them.
const COUNT_EVERY: Duration = Duration::from_secs(1);

impl Service {
    /// What is counted and measured.
    pub fn metrics(&self) -> &Metrics {
        &self.0.shared.metrics
    }

    /// All numbers as they stand. Answers within about a second even when the store does not: the
    /// numbers of jobs are left out then.
    pub async fn scrape(&self, format: Format) -> Result<String, fmt::Error> {
        if tokio::time::timeout(PATIENCE, self.0.count_jobs())
            .await
            .is_err()
        {
            self.metrics().jobs.forget_stock();
        }
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
        let mut counted = self.counted.lock().await;
        if counted.is_some_and(|at| at.elapsed() < COUNT_EVERY) {
            return;
        }
        let numbers = &self.shared.metrics.jobs;
        let Ok(stock) = self.store.stock().await else {
            *counted = None;
            return numbers.forget_stock();
        };
        let of = |state| stock.jobs.iter().find(|(found, _)| *found == state);
        let by_state =
            JobState::ALL.map(|state| (state.name(), of(state).map_or(0, |(_, jobs)| *jobs)));
        let oldest = stock.oldest_queued.map_or(Duration::ZERO, |id| id.age());
        numbers.set_stock(by_state, oldest);
        *counted = Some(Instant::now());
    }
}
