//! The coordinator of a process that shares its store.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use parking_lot::Mutex;

use super::coordinator::Coordinator;
use super::notifier::Notifier;
use crate::wire::{JobId, Progress};

/// How long the content of a notice is remembered.
const NOTICE_LIFETIME: Duration = Duration::from_secs(20);

/// Sends notices through a [`Notifier`], and remembers what was received.
#[derive(Debug)]
pub struct SharedCoordinator {
    notifier: Notifier,
    fence: Duration,
    received: Mutex<Received>,
}

/// The latest notices of other processes about jobs, with their times.
#[derive(Debug, Default)]
struct Received {
    /// Progress of their runs.
    progress: HashMap<JobId, (u64, Progress, Instant)>,
    /// Jobs that have to stop; they do not run here, or not yet.
    stops: HashMap<JobId, Instant>,
}

impl SharedCoordinator {
    /// Leases must not be relied on when their last renewal is `fence` ago.
    pub fn new(notifier: Notifier, fence: Duration) -> Self {
        Self {
            notifier,
            fence,
            received: Mutex::default(),
        }
    }

    /// Returns the sender of notices.
    pub fn notifier(&self) -> &Notifier {
        &self.notifier
    }

    /// Remembers the progress of a run elsewhere, unless a newer one is known: notices may overtake each other.
    pub fn remember_progress(&self, job: JobId, revision: u64, progress: Progress) {
        let mut received = self.received.lock();
        let known = received.progress.get(&job);
        if known.is_none_or(|(known, ..)| *known < revision) {
            let entry = (revision, progress, Instant::now());
            received.progress.insert(job, entry);
        }
    }

    /// Forgets the progress of a job whose record in the store has changed: the record is newer.
    pub fn forget_progress(&self, job: JobId) {
        self.received.lock().progress.remove(&job);
    }

    /// Forgets what was received long ago.
    pub fn forget_old(&self) {
        let mut received = self.received.lock();
        let is_new = |at: &Instant| at.elapsed() < NOTICE_LIFETIME;
        received.progress.retain(|_, (.., at)| is_new(at));
        received.stops.retain(|_, at| is_new(at));
    }
}

impl Coordinator for SharedCoordinator {
    fn fence(&self) -> Option<Duration> {
        Some(self.fence)
    }

    fn notify_queued(&self) {
        self.notifier.queued();
    }

    fn notify_stopped(&self, job: JobId) {
        self.notifier.stopped(job);
    }

    fn notify_changed(&self, job: JobId) {
        self.notifier.changed(job);
    }

    fn notify_progress(&self, job: JobId, revision: u64, progress: &Progress) {
        self.notifier.progressed(job, revision, progress);
    }

    fn request_notices(&self, job: JobId) {
        self.notifier.follow(job);
    }

    fn remote_progress(&self, job: JobId) -> Option<(u64, Progress)> {
        let received = self.received.lock();
        let (revision, progress, _) = received.progress.get(&job)?;
        Some((*revision, progress.clone()))
    }

    fn remember_stop(&self, job: JobId) {
        self.received.lock().stops.insert(job, Instant::now());
    }

    fn may_be_stopped(&self, job: JobId) -> bool {
        self.received.lock().stops.contains_key(&job)
    }
}
