//! The jobs that run now.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::changes::Changes;
use super::control::{Control, Stop};
use crate::store::Lease;
use crate::wire::{JobId, JobRecord, JobState};

/// Most runs that go on although they were given up, each on threads and in memory of its own.
const MAX_ABANDONED: usize = 4;

/// All jobs that run now.
#[derive(Debug)]
pub struct Running {
    changes: Arc<Changes>,
    runs: Mutex<Runs>,
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
        }
    }

    /// Enters a job that the worker at `place` has just claimed, with its settings as JSON.
    pub fn enter(&self, place: usize, lease: Lease, revision: u64, request: &str) -> Arc<Control> {
        let job = lease.job;
        let changes = Arc::clone(&self.changes);
        let control = Arc::new(Control::new(place, lease, revision, request, changes));
        self.lock().controls.insert(job, Arc::clone(&control));
        self.changes.stored(job);
        control
    }

    /// Takes a run out that has come back. Says whether its worker still has its place.
    pub fn leave(&self, control: &Arc<Control>) -> bool {
        let mut runs = self.lock();
        if control.is_abandoned() {
            runs.abandoned -= 1;
            return false;
        }
        runs.take(control);
        true
    }

    /// Gives up a run that does not come back. Fails when it just did, and when too many were given up
    /// that still go on.
    pub fn abandon(&self, control: &Arc<Control>) -> bool {
        let mut runs = self.lock();
        if runs.abandoned >= MAX_ABANDONED || !runs.take(control) {
            return false;
        }
        control.abandon();
        runs.abandoned += 1;
        true
    }

    /// Asks the run of a job to stop, if it runs here.
    pub fn raise(&self, job: JobId, stop: Stop) -> Option<Arc<Control>> {
        let control = self.lock().controls.get(&job).cloned()?;
        control.raise(stop);
        Some(control)
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

    /// Brings the record of a running job up to the moment.
    pub fn refresh(&self, record: &mut JobRecord) {
        if record.state != JobState::Running {
            return;
        }
        if let Some(control) = self.lock().controls.get(&record.id) {
            let (revision, progress) = control.live();
            record.revision = record.revision.max(revision);
            record.progress = Some(progress);
        }
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
