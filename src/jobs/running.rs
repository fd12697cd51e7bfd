//! The jobs that run in this process.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use parking_lot::Mutex;

use super::control::Control;
use crate::cluster::{Changes, HeldLease};
use crate::store::Lease;
use crate::wire::{JobId, JobRecord, JobState};

/// Most abandoned runs that have not returned; each holds threads and memory.
const MAX_ABANDONED: usize = 4;

/// All runs of this process.
pub struct Running {
    changes: Arc<Changes>,
    runs: Mutex<Runs>,
}

#[derive(Default)]
struct Runs {
    controls: HashMap<JobId, Arc<Control>>,
    /// Abandoned runs that have not returned.
    abandoned: usize,
}

impl Running {
    /// Nothing runs.
    pub fn new(changes: Arc<Changes>) -> Self {
        Self {
            changes,
            runs: Mutex::default(),
        }
    }

    /// Enters a job that a worker has just claimed; see [`Control::new`].
    pub fn enter(
        &self,
        worker: usize,
        lease: Lease,
        asked: Instant,
        revision: u64,
        request: &str,
    ) -> Arc<Control> {
        let job = lease.job;
        let control = Arc::new(Control::new(worker, lease, asked, revision, request));
        self.runs.lock().controls.insert(job, Arc::clone(&control));
        self.changes.announce_record(job);
        control
    }

    /// A run has returned, and its outcome is about to be written. Returns whether its worker still has its
    /// slot.
    pub fn set_returned(&self, control: &Control) -> bool {
        let mut runs = self.runs.lock();
        control.set_returned();
        if control.is_abandoned() {
            runs.abandoned -= 1;
            return false;
        }
        true
    }

    /// Removes a run whose outcome is written.
    pub fn leave(&self, control: &Arc<Control>) {
        self.runs.lock().remove(control);
    }

    /// Abandons a run that does not return. Returns whether that was possible: not if it has just returned, nor while
    /// too many abandoned runs go on.
    pub fn abandon(&self, control: &Arc<Control>) -> bool {
        let mut runs = self.runs.lock();
        if runs.abandoned >= MAX_ABANDONED || control.has_returned() || !runs.remove(control) {
            return false;
        }
        control.set_abandoned();
        runs.abandoned += 1;
        true
    }

    /// Returns the run of a job, if it is here.
    pub fn get(&self, job: JobId) -> Option<Arc<Control>> {
        self.runs.lock().controls.get(&job).cloned()
    }

    /// Returns the lease of a job, if it runs here.
    pub fn lease_of(&self, job: JobId) -> Option<Arc<HeldLease>> {
        Some(Arc::clone(&self.get(job)?.held))
    }

    /// Returns all runs.
    pub fn all(&self) -> Vec<Arc<Control>> {
        self.runs.lock().controls.values().cloned().collect()
    }

    /// Returns the leases of all runs.
    pub fn leases(&self) -> Vec<Arc<HeldLease>> {
        let runs = self.runs.lock();
        let leases = runs.controls.values().map(|run| Arc::clone(&run.held));
        leases.collect()
    }

    pub fn is_empty(&self) -> bool {
        self.runs.lock().controls.is_empty()
    }

    /// Returns the age of the oldest run.
    pub fn longest(&self) -> Duration {
        let age = |control: &Arc<Control>| control.held.entered.elapsed();
        let runs = self.runs.lock();
        runs.controls.values().map(age).max().unwrap_or_default()
    }

    /// Brings the record of a running job up to date, as far as that is known here.
    pub fn refresh(&self, record: &mut JobRecord) {
        if record.state != JobState::Running {
            return;
        }
        if let Some(held) = self.lease_of(record.id) {
            let (revision, progress) = held.published();
            record.revision = record.revision.max(revision);
            record.progress = Some(progress);
            return;
        }
        // It runs elsewhere. If this is the first time that somebody here asks, its notices begin now.
        let coordinator = self.changes.coordinator();
        coordinator.request_notices(record.id);
        if let Some((revision, progress)) = coordinator.remote_progress(record.id)
            && revision > record.revision
        {
            record.revision = revision;
            record.progress = Some(progress);
        }
    }
}

impl Runs {
    /// Removes a run, and returns whether it was there: a job that was put back can be running again by now, under
    /// another lease.
    fn remove(&mut self, control: &Arc<Control>) -> bool {
        let job = control.held.lease.job;
        let there = self.controls.get(&job);
        let is_this = there.is_some_and(|there| Arc::ptr_eq(there, control));
        if is_this {
            self.controls.remove(&job);
        }
        is_this
    }
}
