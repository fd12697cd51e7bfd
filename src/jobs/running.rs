//! The jobs that run now.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::changes::Changes;
use super::control::Control;
use crate::store::Lease;
use crate::wire::{JobId, JobRecord, JobState, Progress};

/// Most runs that go on although they were given up, each on threads and in memory of its own.
const MAX_ABANDONED: usize = 4;

/// How long what was heard from other processes is worth something.
const HEARSAY_TIME: Duration = Duration::from_secs(20);

/// All jobs that run now.
#[derive(Debug)]
pub struct Running {
    changes: Arc<Changes>,
    runs: Mutex<Runs>,
    elsewhere: Mutex<Elsewhere>,
}

/// What was heard of jobs that run in other processes.
#[derive(Debug, Default)]
struct Elsewhere {
    /// Where runs stand, and when that was heard.
    standing: HashMap<JobId, (u64, Progress, Instant)>,
    /// Jobs that are to stop and do not run here, or not yet.
    stops: HashMap<JobId, Instant>,
}

#[derive(Debug, Default)]
struct Runs {
    controls: HashMap<JobId, Arc<Control>>,
    /// Runs that were given up and have not come back.
    abandoned: usize,
}

impl Running {
    pub fn new(changes: Arc<Changes>) -> Self {
        Self {
            changes,
            runs: Mutex::default(),
            elsewhere: Mutex::default(),
        }
    }

    /// Enters a job that the worker at `place` has just claimed, as it asked at `asked`, with its settings as JSON.
    pub fn enter(
        &self,
        place: usize,
        lease: Lease,
        asked: Instant,
        revision: u64,
        request: &str,
    ) -> Arc<Control> {
        let job = lease.job;
        let changes = Arc::clone(&self.changes);
        let control = Control::new(place, lease, asked, revision, request, changes);
        let control = Arc::new(control);
        self.lock().controls.insert(job, Arc::clone(&control));
        self.changes.stored(job);
        control
    }

    /// Takes note that a run has come back; what became of it is to be written down. Says whether its worker still has
    /// its place.
    pub fn come_back(&self, control: &Control) -> bool {
        let mut runs = self.lock();
        control.come_back();
        if control.is_abandoned() {
            runs.abandoned -= 1;
            return false;
        }
        true
    }

    /// Takes a run out of which all is written down.
    pub fn leave(&self, control: &Arc<Control>) {
        self.lock().take(control);
    }

    /// Gives up a run that does not come back. Fails when it just did, and when too many were given up
    /// that still go on.
    pub fn abandon(&self, control: &Arc<Control>) -> bool {
        let mut runs = self.lock();
        if runs.abandoned >= MAX_ABANDONED || control.has_returned() || !runs.take(control) {
            return false;
        }
        control.abandon();
        runs.abandoned += 1;
        true
    }

    /// The run of a job, if it is here.
    pub fn of(&self, job: JobId) -> Option<Arc<Control>> {
        self.lock().controls.get(&job).cloned()
    }

    /// How long the job has been running that runs for longest.
    pub fn longest(&self) -> Duration {
        let ages = |control: &Arc<Control>| control.entered.elapsed();
        let runs = self.lock();
        runs.controls.values().map(ages).max().unwrap_or_default()
    }

    pub fn all(&self) -> Vec<Arc<Control>> {
        self.lock().controls.values().cloned().collect()
    }

    /// Whether a job runs here.
    pub fn is_here(&self, job: JobId) -> bool {
        self.lock().controls.contains_key(&job)
    }

    pub fn is_empty(&self) -> bool {
        self.lock().controls.is_empty()
    }

    /// Brings the record of a running job up to the moment, as far as that is known here.
    pub fn refresh(&self, record: &mut JobRecord) {
        if record.state != JobState::Running {
            return;
        }
        if let Some(control) = self.lock().controls.get(&record.id) {
            let (revision, progress) = control.live();
            record.revision = record.revision.max(revision);
            record.progress = Some(progress);
            return;
        }
        // Elsewhere, and perhaps not for long; whoever waits is told of what comes.
        self.changes.ask(record.id);
        if let Some((revision, progress, _)) = self.elsewhere().standing.get(&record.id)
            && *revision > record.revision
        {
            record.revision = *revision;
            record.progress = Some(progress.clone());
        }
    }

    /// Another process tells where a run stands.
    pub fn hear(&self, job: JobId, revision: u64, progress: Progress) {
        let mut elsewhere = self.elsewhere();
        let known = elsewhere.standing.get(&job);
        // The line does not promise their order.
        if known.is_none_or(|(known, ..)| *known < revision) {
            let heard = (revision, progress, Instant::now());
            elsewhere.standing.insert(job, heard);
        }
    }

    /// The record of a job in the store has changed: it tells more than what was heard.
    pub fn forget_elsewhere(&self, job: JobId) {
        self.elsewhere().standing.remove(&job);
    }

    /// A job on a shared store was cancelled or forgotten: its run, if it is here. If not, it is remembered for a moment,
    /// in which a worker may enter it.
    pub fn expect_stop(&self, job: JobId) -> Option<Arc<Control>> {
        // In this order, and in the other one where a run is entered.
        self.elsewhere().stops.insert(job, Instant::now());
        self.of(job)
    }

    /// Whether it was heard just now that a job is to stop.
    pub fn is_expected_to_stop(&self, job: JobId) -> bool {
        self.elsewhere().stops.contains_key(&job)
    }

    /// Forgets what was heard long ago.
    pub fn forget_old(&self) {
        let mut elsewhere = self.elsewhere();
        let is_new = |heard: &Instant| heard.elapsed() < HEARSAY_TIME;
        elsewhere.standing.retain(|_, (.., heard)| is_new(heard));
        elsewhere.stops.retain(|_, heard| is_new(heard));
    }

    fn elsewhere(&self) -> MutexGuard<'_, Elsewhere> {
        self.elsewhere
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn lock(&self) -> MutexGuard<'_, Runs> {
        self.runs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Runs {
    /// Removes a run, and says whether it was there. A job put back can be running again by now, under
    /// another lease.
    fn take(&mut self, control: &Arc<Control>) -> bool {
        let job = control.lease.job;
        let there = self.controls.get(&job);
        let is_this = there.is_some_and(|there| Arc::ptr_eq(there, control));
        if is_this {
            self.controls.remove(&job);
        }
        is_this
    }
}
