//! Receives the progress of one run.

use std::time::{Duration, Instant};

use prometheus_client::metrics::counter::Counter;

use crate::cluster::{Changes, HeldLease};
use crate::wire::Progress;

/// Least time between two published states of one job; a search reports far more often.
const PUBLISH_EVERY: Duration = Duration::from_millis(50);

/// Publishes the progress of a run.
pub struct Observer<'a> {
    held: &'a HeldLease,
    changes: &'a Changes,
    /// Counts the evaluations of all runs.
    evaluations: &'a Counter,
    /// The evaluations of this run that are counted already.
    counted: u64,
    published: Option<Instant>,
    latest: Option<Progress>,
}

impl<'a> Observer<'a> {
    /// An observer of a run that has reported nothing yet.
    pub fn new(held: &'a HeldLease, changes: &'a Changes, evaluations: &'a Counter) -> Self {
        Self {
            held,
            changes,
            evaluations,
            counted: 0,
            published: None,
            latest: None,
        }
    }

    /// Receives the progress of the run.
    pub fn observe(&mut self, progress: &Progress) {
        self.latest = Some(progress.clone());
        if self
            .published
            .is_none_or(|at| at.elapsed() >= PUBLISH_EVERY)
        {
            self.publish(progress);
            self.published = Some(Instant::now());
        }
    }

    /// Publishes the last progress.
    pub fn end(mut self) {
        if let Some(progress) = self.latest.take() {
            self.publish(&progress);
        }
    }

    fn publish(&mut self, progress: &Progress) {
        if let Some((revision, published)) = self.held.publish(progress) {
            let job = self.held.lease.job;
            self.changes.announce_progress(job, revision, &published);
        }
        let done = progress.evaluations;
        // Where the run starts over, as between trials, its count does.
        let new = done.checked_sub(self.counted).unwrap_or(done);
        self.evaluations.inc_by(new);
        self.counted = done;
    }
}
