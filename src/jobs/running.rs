//! The jobs that run now: their progress on its way out, the wish to stop on its way in.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use prometheus_client::metrics::counter::Counter;
use tokio::sync::watch;

use crate::store::Lease;
use crate::wire::{JobId, JobRecord, Phase, Progress};

/// Least time between two published states of one job; a search reports far more often.
const PUBLISH_EVERY: Duration = Duration::from_millis(50);

/// Why a run is to stop before its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// Keep what was found.
    Cancel,
    /// The job is forgotten; so is what was found.
    Discard,
    /// The server stops; the job runs again from its start.
    Release,
}

/// What clients see of a run between two writes to the store.
#[derive(Debug, Clone)]
struct Live {
    revision: u64,
    progress: Progress,
}

/// One running job.
#[derive(Debug)]
pub struct Control {
    pub lease: Lease,
    entered: Instant,
    stop: OnceLock<Stop>,
    live: watch::Sender<Live>,
}

impl Control {
    /// Asks the run to stop. The first wish stands.
    pub fn raise(&self, stop: Stop) {
        let _ = self.stop.set(stop);
    }

    pub fn stop(&self) -> Option<Stop> {
        self.stop.get().copied()
    }

    /// Whether the planner has not started yet.
    pub fn is_preparing(&self) -> bool {
        self.live.borrow().progress.phase == Phase::Preparing
    }

    pub fn progress(&self) -> Progress {
        self.live().progress
    }

    /// The revision and the progress that belong together.
    fn live(&self) -> Live {
        let mut live = self.live.borrow().clone();
        if live.progress.phase == Phase::Preparing {
            // Nobody reports while a mesh is prepared.
            live.progress.elapsed_s = self.entered.elapsed().as_secs_f64();
        }
        live
    }

    /// The last revision that clients may have seen.
    pub fn revision(&self) -> u64 {
        self.live.borrow().revision
    }

    fn publish(&self, progress: &Progress) {
        self.live.send_modify(|live| {
            live.revision += 1;
            live.progress = progress.clone();
            // The planner counts from its own start; time is not to jump back after preparing.
            live.progress.elapsed_s = self.entered.elapsed().as_secs_f64();
        });
    }
}

/// Listens to a run on behalf of its [`Control`].
pub struct Observer<'a> {
    control: &'a Control,
    evaluations: &'a Counter,
    /// Evaluations of this run that are counted already.
    counted: u64,
    published: Option<Instant>,
    latest: Option<Progress>,
    stopped: bool,
}

impl<'a> Observer<'a> {
    /// `evaluations` counts those of all runs.
    pub fn new(control: &'a Control, evaluations: &'a Counter) -> Self {
        Self {
            control,
            evaluations,
            counted: 0,
            published: None,
            latest: None,
            stopped: false,
        }
    }

    /// Takes note of where the run stands and says whether it may go on.
    pub fn note(&mut self, progress: &Progress) -> ControlFlow<()> {
        self.latest = Some(progress.clone());
        if self
            .published
            .is_none_or(|at| at.elapsed() >= PUBLISH_EVERY)
        {
            self.publish(progress);
            self.published = Some(Instant::now());
        }
        self.stopped = self.control.stop().is_some();
        match self.stopped {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    /// Publishes the last state. Says whether the run was told to stop.
    pub fn end(mut self) -> bool {
        if let Some(progress) = self.latest.take() {
            self.publish(&progress);
        }
        self.stopped
    }

    fn publish(&mut self, progress: &Progress) {
        self.control.publish(progress);
        let done = progress.evaluations;
        // Where the run starts over, as between trials, its count does.
        let new = done.checked_sub(self.counted).unwrap_or(done);
        self.evaluations.inc_by(new);
        self.counted = done;
    }
}

/// All jobs that run now.
#[derive(Debug, Default)]
pub struct Running {
    controls: Mutex<HashMap<JobId, Arc<Control>>>,
}

impl Running {
    /// Enters a job that was just claimed, with its settings as JSON; it leaves when the entry
    /// is dropped.
    pub fn enter(&self, lease: Lease, revision: u64, request: &str) -> Entry<'_> {
        /// The one setting that is told before the planner tells it.
        #[derive(serde::Deserialize)]
        struct Asked {
            generations: u64,
        }
        let asked = serde_json::from_str::<Asked>(request);
        let live = Live {
            revision,
            progress: Progress {
                phase: Phase::Preparing,
                generation: 0,
                generations: asked.map_or(0, |asked| asked.generations),
                evaluations: 0,
                best_quality: None,
                elapsed_s: 0.0,
            },
        };
        let control = Arc::new(Control {
            lease,
            entered: Instant::now(),
            stop: OnceLock::new(),
            live: watch::Sender::new(live),
        });
        self.lock().insert(control.lease.job, Arc::clone(&control));
        Entry {
            running: self,
            control,
        }
    }

    /// Asks the run of a job to stop, if it runs here.
    pub fn raise(&self, job: JobId, stop: Stop) -> Option<Arc<Control>> {
        let control = self.lock().get(&job).cloned()?;
        control.raise(stop);
        Some(control)
    }

    /// How long the job has been running that runs for longest.
    pub fn longest(&self) -> Duration {
        let ages = |control: &Arc<Control>| control.entered.elapsed();
        self.lock().values().map(ages).max().unwrap_or_default()
    }

    pub fn all(&self) -> Vec<Arc<Control>> {
        self.lock().values().cloned().collect()
    }

    /// Brings the record of a running job up to the moment.
    pub fn refresh(&self, record: &mut JobRecord) {
        if record.state.is_final() {
            return;
        }
        if let Some(control) = self.lock().get(&record.id) {
            let Live { revision, progress } = control.live();
            record.revision = record.revision.max(revision);
            record.progress = Some(progress);
        }
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<JobId, Arc<Control>>> {
        self.controls.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The presence of a job among those that run.
pub struct Entry<'a> {
    running: &'a Running,
    pub control: Arc<Control>,
}

impl Drop for Entry<'_> {
    fn drop(&mut self) {
        let mut controls = self.running.lock();
        // A job put back can be running again by now, under another lease.
        let job = self.control.lease.job;
        if controls
            .get(&job)
            .is_some_and(|control| Arc::ptr_eq(control, &self.control))
        {
            controls.remove(&job);
        }
    }
}
