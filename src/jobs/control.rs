//! How a run and the rest of the process meet: what is known of a run, and what was decided about it.
//!
//! The run itself sees only the request to stop, in its [`HeldLease`]. The watchdog counts how long a run that should
//! end does not; it may overrule it (end its job without it) and abandon it (give its worker's slot to another).

use std::sync::Arc;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use crate::cluster::{HeldLease, RunStop};
use crate::store::Lease;
use crate::wire::Progress;
use graspd_core::search::Phase;

/// One running job.
#[derive(Debug)]
pub struct Control {
    pub held: Arc<HeldLease>,
    /// The slot of the worker that runs it.
    pub worker: usize,
    /// When the planner began.
    begun: OnceLock<Instant>,
    time_limit: Option<Duration>,
    /// How many checks in a row have found the run still there although it should have ended.
    overtime: AtomicU32,
    /// The run has returned; its outcome is being written.
    returned: AtomicBool,
    /// The job is being ended without its run, and that is done.
    overruling: AtomicBool,
    overruled: AtomicBool,
    /// Another worker has the slot of the one that runs it.
    abandoned: AtomicBool,
}

impl Control {
    /// The control of a job that a worker has just claimed: the claim was sent at `asked` and left the job at
    /// `revision`; its settings are `request`, as JSON.
    pub fn new(worker: usize, lease: Lease, asked: Instant, revision: u64, request: &str) -> Self {
        /// The settings that are needed before the planner reads them all.
        #[derive(serde::Deserialize)]
        struct Settings {
            generations: u64,
            time_limit_s: Option<f64>,
        }
        let settings = serde_json::from_str::<Settings>(request).ok();
        let progress = Progress {
            phase: Phase::Preparing,
            generation: 0,
            generations: settings.as_ref().map_or(0, |settings| settings.generations),
            evaluations: 0,
            best_quality: None,
            best_contacts: None,
            elapsed_s: 0.0,
        };
        let limit = settings.and_then(|settings| settings.time_limit_s);
        Self {
            held: Arc::new(HeldLease::new(lease, asked, revision, progress)),
            worker,
            begun: OnceLock::new(),
            time_limit: limit.and_then(|limit| Duration::try_from_secs_f64(limit).ok()),
            overtime: AtomicU32::new(0),
            returned: AtomicBool::new(false),
            overruling: AtomicBool::new(false),
            overruled: AtomicBool::new(false),
            abandoned: AtomicBool::new(false),
        }
    }

    /// Requests that the run stops. The first request stands.
    pub fn request_stop(&self, reason: RunStop) {
        self.held.request_stop(reason);
    }

    /// Returns why the run has to stop, if it has to.
    pub fn stop_reason(&self) -> Option<RunStop> {
        self.held.stop_reason()
    }

    /// Returns for how long the run has ignored a cancellation.
    pub fn cancelled_for(&self) -> Option<Duration> {
        match self.has_returned() {
            true => None,
            false => self.held.stopping_for(RunStop::Cancel),
        }
    }

    /// The planner begins: its time limit counts from here.
    pub fn begin(&self) {
        let _ = self.begun.set(Instant::now());
    }

    /// Checks whether the run should have ended, and returns how many checks in a row have found that, including this one;
    /// 0 if it may go on.
    ///
    /// Checks are counted and not seconds, so that a process that was halted gives its runs the time to react.
    ///
    /// `preparing` is the longest that may pass before the planner begins. From then on a run has its time limit for
    /// the search and as much again for the analyses of the grasp.
    pub fn check(&self, preparing: Duration) -> u32 {
        let is_late =
            !self.has_returned() && (self.stop_reason().is_some() || self.is_late(preparing));
        if !is_late {
            self.overtime.store(0, Ordering::Relaxed);
            return 0;
        }
        self.overtime.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Returns what the last check counted.
    pub fn overtime(&self) -> u32 {
        self.overtime.load(Ordering::Relaxed)
    }

    fn is_late(&self, preparing: Duration) -> bool {
        match (self.begun.get(), self.time_limit) {
            (None, _) => self.held.entered.elapsed() > preparing,
            (Some(begun), Some(limit)) => begun.elapsed() > limit.saturating_mul(2),
            (Some(_), None) => false,
        }
    }

    /// The run has returned. Its outcome may have to wait for the store, which does not make it late.
    pub fn set_returned(&self) {
        self.returned.store(true, Ordering::Relaxed);
    }

    pub fn has_returned(&self) -> bool {
        self.returned.load(Ordering::Relaxed)
    }

    /// Returns whether the run has returned or was asked to stop.
    pub fn is_ending(&self) -> bool {
        self.has_returned() || self.stop_reason().is_some()
    }

    /// Returns whether the caller is the first to overrule the run, which has not returned.
    pub fn begin_overruling(&self) -> bool {
        !self.has_returned() && !self.overruling.swap(true, Ordering::Relaxed)
    }

    /// The job was ended without its run.
    pub fn set_overruled(&self) {
        self.overruled.store(true, Ordering::Relaxed);
    }

    pub fn is_overruled(&self) -> bool {
        self.overruled.load(Ordering::Relaxed)
    }

    /// Another worker takes the slot of the one that runs it.
    pub fn set_abandoned(&self) {
        self.abandoned.store(true, Ordering::Relaxed);
    }

    pub fn is_abandoned(&self) -> bool {
        self.abandoned.load(Ordering::Relaxed)
    }
}
