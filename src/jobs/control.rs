//! How a run and the rest of the service meet: progress on its way out, the wish to stop on its way in.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use prometheus_client::metrics::counter::Counter;

use super::changes::Changes;
use crate::store::Lease;
use crate::wire::{Phase, Progress};

/// Least time between two published states of one job; a search reports far more often.
const PUBLISH_EVERY: Duration = Duration::from_millis(50);

/// Why a run is to stop before its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// Keep what was found.
    Cancel,
    /// The job is forgotten or was ended by others; what was found is of no use.
    Discard,
    /// The server stops; the job runs again from its start.
    Release,
}

/// What clients see of a run between two writes to the store.
#[derive(Debug, Clone)]
struct Live {
    revision: u64,
    progress: Progress,
    /// Whether the end of the job is being written, after which nothing more is to be seen.
    closed: bool,
}

/// One running job.
#[derive(Debug)]
pub struct Control {
    pub lease: Lease,
    /// The number of the worker that runs it.
    pub place: usize,
    pub entered: Instant,
    /// When the lease was last asked for and given.
    renewed: Mutex<Instant>,
    /// When the planner began.
    begun: OnceLock<Instant>,
    time_limit: Option<Duration>,
    /// The wish, and when it was told.
    stop: OnceLock<(Stop, Instant)>,
    live: Mutex<Live>,
    changes: Arc<Changes>,
    /// How many looks in a row have found the run still there although it was to end.
    overtime: AtomicU32,
    /// Whether the run has come back; what became of it is being written down.
    returned: AtomicBool,
    /// Whether the job is being ended over the head of the run, and whether that is done.
    overruling: AtomicBool,
    overruled: AtomicBool,
    /// Whether the worker was given up, its place taken by another.
    abandoned: AtomicBool,
}

impl Control {
    /// Of a job that the worker at `place` has just claimed, which it asked for at `asked`, with its settings as
    /// JSON.
    pub fn new(
        place: usize,
        lease: Lease,
        asked: Instant,
        revision: u64,
        request: &str,
        changes: Arc<Changes>,
    ) -> Self {
        /// The settings that are needed before the planner reads them all.
        #[derive(serde::Deserialize)]
        struct Asked {
            generations: u64,
            time_limit_s: Option<f64>,
        }
        let settings = serde_json::from_str::<Asked>(request).ok();
        let live = Live {
            revision,
            progress: Progress {
                phase: Phase::Preparing,
                generation: 0,
                generations: settings.as_ref().map_or(0, |settings| settings.generations),
                evaluations: 0,
                best_quality: None,
                best_contacts: None,
                elapsed_s: 0.0,
            },
            closed: false,
        };
        let limit = settings.and_then(|settings| settings.time_limit_s);
        Self {
            lease,
            place,
            entered: Instant::now(),
            renewed: Mutex::new(asked),
            begun: OnceLock::new(),
            time_limit: limit.and_then(|limit| Duration::try_from_secs_f64(limit).ok()),
            stop: OnceLock::new(),
            live: Mutex::new(live),
            changes,
            overtime: AtomicU32::new(0),
            returned: AtomicBool::new(false),
            overruling: AtomicBool::new(false),
            overruled: AtomicBool::new(false),
            abandoned: AtomicBool::new(false),
        }
    }

    /// Asks the run to stop. The first wish stands.
    pub fn raise(&self, stop: Stop) {
        let _ = self.stop.set((stop, Instant::now()));
    }

    pub fn stop(&self) -> Option<Stop> {
        self.stop.get().map(|(stop, _)| *stop)
    }

    /// Takes note that the lease was renewed, as asked at that moment.
    pub fn renewed(&self, asked: Instant) {
        *self.renewed.lock().unwrap_or_else(PoisonError::into_inner) = asked;
    }

    /// For how long the lease has not been renewed.
    pub fn unrenewed(&self) -> Duration {
        let renewed = self.renewed.lock();
        renewed.unwrap_or_else(PoisonError::into_inner).elapsed()
    }

    /// How long ago the run was told to stop because its job was cancelled.
    pub fn cancelled_for(&self) -> Option<Duration> {
        match self.stop.get() {
            Some((Stop::Cancel, told)) if !self.has_returned() => Some(told.elapsed()),
            _ => None,
        }
    }

    /// Takes note that the planner begins; its time counts from here.
    pub fn begin(&self) {
        let _ = self.begun.set(Instant::now());
    }

    /// Counts the looks at a run that was told to stop or whose time is over: those in a row that have
    /// found it so, this one among them. 0 for one that may go on.
    ///
    /// Looks and not seconds, so that a process that was halted gives its runs the time to react.
    ///
    /// `preparing` is the longest that may pass before the planner begins. From then on a run has its time
    /// limit for the search and as much again for what is told of the grasp.
    pub fn look(&self, preparing: Duration) -> u32 {
        let late = !self.has_returned() && (self.stop().is_some() || self.is_late(preparing));
        if !late {
            self.overtime.store(0, Ordering::Relaxed);
            return 0;
        }
        self.overtime.fetch_add(1, Ordering::Relaxed) + 1
    }

    fn is_late(&self, preparing: Duration) -> bool {
        match (self.begun.get(), self.time_limit) {
            (None, _) => self.entered.elapsed() > preparing,
            (Some(begun), Some(limit)) => begun.elapsed() > limit.saturating_mul(2),
            (Some(_), None) => false,
        }
    }

    /// Takes note that the run has come back: what it has to say may wait for the store, and is not late.
    pub fn come_back(&self) {
        self.returned.store(true, Ordering::Relaxed);
    }

    pub fn has_returned(&self) -> bool {
        self.returned.load(Ordering::Relaxed)
    }

    /// Whether the run has come back or was told to stop.
    pub fn is_ending(&self) -> bool {
        self.has_returned() || self.stop().is_some()
    }

    /// Says whether the caller is the first to end the job over the head of a run that is not back.
    pub fn begin_overruling(&self) -> bool {
        !self.has_returned() && !self.overruling.swap(true, Ordering::Relaxed)
    }

    /// What the last look counted.
    pub fn overtime(&self) -> u32 {
        self.overtime.load(Ordering::Relaxed)
    }

    /// Takes note that the job was ended without waiting for the run.
    pub fn overrule(&self) {
        self.overruled.store(true, Ordering::Relaxed);
    }

    pub fn is_overruled(&self) -> bool {
        self.overruled.load(Ordering::Relaxed)
    }

    /// Takes note that the worker was given up.
    pub fn abandon(&self) {
        self.abandoned.store(true, Ordering::Relaxed);
    }

    pub fn is_abandoned(&self) -> bool {
        self.abandoned.load(Ordering::Relaxed)
    }

    /// The revision and the progress that belong together.
    pub fn live(&self) -> (u64, Progress) {
        let mut live = self.lock().clone();
        if live.progress.phase == Phase::Preparing {
            // Nobody reports while a mesh is prepared.
            live.progress.elapsed_s = self.entered.elapsed().as_secs_f64();
        }
        (live.revision, live.progress)
    }

    /// Publishes nothing from here on, and gives the last revision that clients may have seen with its
    /// progress: what the end of the job is to be written with. The contacts are the result's to tell.
    pub fn close(&self) -> (u64, Progress) {
        self.lock().closed = true;
        let (revision, progress) = self.live();
        let progress = Progress {
            best_contacts: None,
            ..progress
        };
        (revision, progress)
    }

    /// Lets the next revision be past that of the record in the store, which has changed.
    pub fn pass(&self, revision: u64) {
        let mut live = self.lock();
        live.revision = live.revision.max(revision);
    }

    fn publish(&self, progress: &Progress) {
        let mut live = self.lock();
        if live.closed {
            return;
        }
        live.revision += 1;
        live.progress = progress.clone();
        // The planner counts from its own start; time is not to jump back after preparing.
        live.progress.elapsed_s = self.entered.elapsed().as_secs_f64();
        let Live {
            revision, progress, ..
        } = live.clone();
        drop(live);
        self.changes.progressed(self.lease.job, revision, &progress);
    }

    fn lock(&self) -> MutexGuard<'_, Live> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
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
