//! Metrics of jobs and of the queue.

use std::sync::atomic::AtomicU64;
use std::time::Duration;

use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::Registry;

use super::{Histograms, LONG_SECONDS, long_histograms};

/// Metrics of jobs and of the queue. Clones are the same metrics.
#[derive(Debug, Clone)]
pub struct JobMetrics {
    /// Jobs accepted.
    pub submitted: Counter,
    /// Quality evaluations of runs, including those under way.
    pub evaluations: Counter,
    /// Panics in runs.
    pub panics: Counter,
    /// Jobs recovered from processes that died.
    pub recovered: Counter,
    wait: Histogram,
    run: Histograms<Ended>,
    by_state: Family<InState, Gauge>,
    oldest: Gauge<f64, AtomicU64>,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunEnd {
    Succeeded,
    Failed,
    Cancelled,
    /// Put back in the queue because the process stops, or cannot keep its lease.
    Released,
    /// The job had been ended or forgotten before its run ended.
    Abandoned,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Ended {
    end: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct InState {
    state: &'static str,
}

impl Default for JobMetrics {
    fn default() -> Self {
        Self {
            submitted: Counter::default(),
            evaluations: Counter::default(),
            panics: Counter::default(),
            recovered: Counter::default(),
            wait: Histogram::new(LONG_SECONDS),
            run: long_histograms(),
            by_state: Family::default(),
            oldest: Gauge::default(),
        }
    }
}

impl JobMetrics {
    /// Counts a run that started `waited` after its job was submitted.
    pub fn started(&self, waited: Duration) {
        self.wait.observe(waited.as_secs_f64());
    }

    /// Counts a run that ended.
    pub fn ended(&self, end: RunEnd, took: Duration) {
        let end = match end {
            RunEnd::Succeeded => "succeeded",
            RunEnd::Failed => "failed",
            RunEnd::Cancelled => "cancelled",
            RunEnd::Released => "released",
            RunEnd::Abandoned => "abandoned",
        };
        self.run
            .get_or_create(&Ended { end })
            .observe(took.as_secs_f64());
    }

    /// Sets how many jobs are in a state; `None` when that is unknown: better no number than an old one.
    pub fn set_jobs(&self, state: &'static str, jobs: Option<u64>) {
        let state = InState { state };
        match jobs {
            Some(jobs) => {
                let gauge = self.by_state.get_or_create_owned(&state);
                gauge.set(jobs.try_into().unwrap_or(i64::MAX));
            }
            None => {
                self.by_state.remove(&state);
            }
        }
    }

    /// Sets how long the oldest queued job has waited; `None` when that is unknown.
    pub fn set_oldest(&self, waited: Option<Duration>) {
        let waited = waited.as_ref().map_or(f64::NAN, Duration::as_secs_f64);
        self.oldest.set(waited);
    }

    pub(super) fn register(&self, registry: &mut Registry) {
        let Self {
            submitted,
            evaluations,
            panics,
            recovered,
            wait,
            run,
            by_state,
            oldest,
        } = self.clone();
        registry.register("jobs", "Jobs kept, by state", by_state);
        registry.register(
            "queue_oldest_wait_seconds",
            "For how long the job has waited that waits longest; 0 when none waits, not a number when the store does not say",
            oldest,
        );
        registry.register("jobs_submitted", "Jobs taken", submitted);
        registry.register(
            "job_wait_seconds",
            "Time from the submission of a job to the start of a run of it",
            wait,
        );
        registry.register(
            "job_run_seconds",
            "Time of a run from its start to its end in the store, by how it ended",
            run,
        );
        registry.register(
            "evaluations",
            "Quality evaluations of runs, those under way among them",
            evaluations,
        );
        registry.register(
            "jobs_taken_up",
            "Jobs taken from processes that were silent for too long, to be run by others",
            recovered,
        );
        registry.register("job_panics", "Panics in runs; each is a bug", panics);
    }
}
