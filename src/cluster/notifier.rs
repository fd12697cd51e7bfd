//! Sends notices to the other processes, a few times a second however much there is.
//!
//! Notices are gathered: those of a few milliseconds go out together, and of the progress of a run only the newest is
//! kept, sent at most five times a second. Of a job that nobody elsewhere follows nothing is sent but that it was
//! cancelled or deleted. Whoever follows a job says so again and again, so that a process that dies, or a notice that
//! is lost, leaves nothing behind that has to be cleaned up.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use tokio::sync::Notify;
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;

use crate::store::{Notice, SharedStore};
use crate::wire::{JobId, Progress};

/// How long notices are gathered before they are sent together.
const GATHERING: Duration = Duration::from_millis(5);
/// Least time between two notices of progress.
const PROGRESS_EVERY: Duration = Duration::from_millis(200);
/// Time after which the interest in a job is announced again.
const FOLLOW_AGAIN: Duration = Duration::from_secs(5);
/// Time after which the interest of another process is forgotten: three announcements may be lost.
const FOLLOW_TIME: Duration = Duration::from_secs(16);
/// Most jobs for which interest is remembered, in each direction.
const MAX_FOLLOWED: usize = 100_000;
/// Pause after notices could not be sent.
const PAUSE: Duration = Duration::from_millis(500);

/// Gathers notices. Clones are the same.
#[derive(Debug, Clone, Default)]
pub struct Notifier(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    pending: Mutex<Pending>,
    /// Something is pending.
    wake: Notify,
    /// The jobs that other processes follow, and when they last said so.
    followed_elsewhere: Mutex<HashMap<JobId, Instant>>,
}

/// The notices to send next.
#[derive(Debug, Default)]
struct Pending {
    queued: bool,
    stopped: HashSet<JobId>,
    changed: HashSet<JobId>,
    followed: HashSet<JobId>,
    /// When the interest of this process in a job was last announced.
    announced: HashMap<JobId, Instant>,
    progress: HashMap<JobId, (u64, Progress)>,
}

impl Notifier {
    /// Sends notices until `stopping`. Those that cannot be sent are dropped: the others find the same in the store.
    pub async fn run(self, store: SharedStore, stopping: CancellationToken) {
        let mut progress_sent = Instant::now();
        while !stopping.is_cancelled() {
            let pause = PROGRESS_EVERY.saturating_sub(progress_sent.elapsed());
            let has_progress = !self.0.pending.lock().progress.is_empty();
            tokio::select! {
                () = stopping.cancelled() => return self.send(&store, true).await,
                () = self.0.wake.notified() => sleep(GATHERING).await,
                () = sleep(pause), if has_progress => {}
            }
            let is_due = progress_sent.elapsed() >= PROGRESS_EVERY;
            if is_due {
                progress_sent = Instant::now();
            }
            self.send(&store, is_due).await;
        }
    }

    async fn send(&self, store: &SharedStore, with_progress: bool) {
        let notices = self.0.pending.lock().take(with_progress);
        if notices.is_empty() {
            return;
        }
        if let Err(error) = store.notify(&notices).await {
            tracing::debug!(%error, "other processes cannot be notified");
            sleep(PAUSE).await;
        }
    }

    /// Jobs wait.
    pub fn queued(&self) {
        self.0.pending.lock().queued = true;
        self.0.wake.notify_one();
    }

    /// A job was cancelled or deleted.
    pub fn stopped(&self, job: JobId) {
        let mut pending = self.0.pending.lock();
        pending.stopped.insert(job);
        pending.changed.insert(job);
        self.0.wake.notify_one();
    }

    /// The record of a job has changed; sent if another process follows the job.
    pub fn changed(&self, job: JobId) {
        if self.is_followed_elsewhere(job) {
            let mut pending = self.0.pending.lock();
            pending.progress.remove(&job);
            pending.changed.insert(job);
            self.0.wake.notify_one();
        }
    }

    /// A run has made progress; sent if another process follows the job.
    pub fn progressed(&self, job: JobId, revision: u64, progress: &Progress) {
        if self.is_followed_elsewhere(job) {
            let mut pending = self.0.pending.lock();
            let is_first = pending.progress.is_empty();
            pending.progress.insert(job, (revision, progress.clone()));
            if is_first {
                self.0.wake.notify_one();
            }
        }
    }

    /// Somebody here follows a job; sent unless that was announced just now.
    pub fn follow(&self, job: JobId) {
        let mut pending = self.0.pending.lock();
        let now = Instant::now();
        let is_recent = |announced: &Instant| now.duration_since(*announced) < FOLLOW_AGAIN;
        if pending.announced.get(&job).is_some_and(is_recent) {
            return;
        }
        if pending.announced.len() >= MAX_FOLLOWED {
            pending
                .announced
                .retain(|_, announced| is_recent(announced));
        }
        pending.announced.insert(job, now);
        pending.followed.insert(job);
        self.0.wake.notify_one();
    }

    /// Another process follows these jobs.
    pub fn add_followed_elsewhere(&self, jobs: &[JobId]) {
        let now = Instant::now();
        let mut followed = self.0.followed_elsewhere.lock();
        followed.extend(jobs.iter().map(|job| (*job, now)));
        if followed.len() > MAX_FOLLOWED {
            followed.retain(|_, announced| now.duration_since(*announced) < FOLLOW_TIME);
        }
        // So many cannot be served; their followers poll the store.
        if followed.len() > MAX_FOLLOWED {
            followed.clear();
        }
    }

    fn is_followed_elsewhere(&self, job: JobId) -> bool {
        let followed = self.0.followed_elsewhere.lock();
        let announced = followed.get(&job);
        announced.is_some_and(|announced| announced.elapsed() < FOLLOW_TIME)
    }
}

impl Pending {
    fn take(&mut self, with_progress: bool) -> Vec<Notice> {
        let mut notices = Vec::new();
        let ids = |jobs: &mut HashSet<JobId>, make: fn(Vec<JobId>) -> Notice| {
            (!jobs.is_empty()).then(|| make(jobs.drain().collect()))
        };
        if std::mem::take(&mut self.queued) {
            notices.push(Notice::Queued);
        }
        notices.extend(ids(&mut self.stopped, Notice::Stopped));
        notices.extend(ids(&mut self.followed, Notice::Followed));
        if with_progress {
            let progress = self.progress.drain();
            notices.extend(
                progress.map(|(job, (revision, progress))| Notice::Progress {
                    job,
                    revision,
                    progress,
                }),
            );
        }
        // Last: the progress of a run must not arrive after its end.
        notices.extend(ids(&mut self.changed, Notice::Changed));
        notices
    }
}
