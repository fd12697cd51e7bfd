//! Tells other processes what they may want to know, a few times a second however much there is.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::Notify;
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;

use crate::store::{Notice, SharedStore};
use crate::wire::{JobId, Progress};

/// How long news are gathered before they are told together.
const GATHERING: Duration = Duration::from_millis(5);
/// Least time between two tellings of how runs stand.
const PROGRESS_EVERY: Duration = Duration::from_millis(200);
/// Time after which it is told again that somebody waits for a job, and after which who was told forgets it.
pub const FOLLOW_AGAIN: Duration = Duration::from_secs(5);
const FOLLOW_TIME: Duration = Duration::from_secs(16);
/// Most jobs of which it is remembered that somebody elsewhere waits for them.
const MAX_FOLLOWED: usize = 100_000;
/// Pause after nobody could be told.
const PAUSE: Duration = Duration::from_millis(500);

/// Gathers what is to be told. Clones are the same.
#[derive(Debug, Clone, Default)]
pub struct Herald(Arc<Inner>);

#[derive(Debug, Default)]
struct Inner {
    news: Mutex<News>,
    some: Notify,
    /// For whom somebody elsewhere waits, and when that was heard last.
    followed: Mutex<HashMap<JobId, Instant>>,
}

/// What is to be told next.
#[derive(Debug, Default)]
struct News {
    queued: bool,
    stopped: HashSet<JobId>,
    changed: HashSet<JobId>,
    followed: HashSet<JobId>,
    /// When it was last told that somebody waits for a job.
    asked: HashMap<JobId, Instant>,
    progress: HashMap<JobId, (u64, Progress)>,
}

impl Herald {
    /// Tells others until the process stops. What cannot be told is dropped: they will find it.
    pub async fn work(self, store: SharedStore, stopping: CancellationToken) {
        let mut told_progress = Instant::now();
        while !stopping.is_cancelled() {
            let pause = PROGRESS_EVERY.saturating_sub(told_progress.elapsed());
            let has_progress = !self.news().progress.is_empty();
            tokio::select! {
                () = stopping.cancelled() => return self.tell(&store, true).await,
                () = self.0.some.notified() => sleep(GATHERING).await,
                () = sleep(pause), if has_progress => {}
            }
            let is_due = told_progress.elapsed() >= PROGRESS_EVERY;
            if is_due {
                told_progress = Instant::now();
            }
            self.tell(&store, is_due).await;
        }
    }

    async fn tell(&self, store: &SharedStore, with_progress: bool) {
        let notices = self.take(with_progress);
        if notices.is_empty() {
            return;
        }
        if let Err(error) = store.tell(&notices).await {
            tracing::debug!(%error, "other processes cannot be told of news");
            sleep(PAUSE).await;
        }
    }

    fn take(&self, with_progress: bool) -> Vec<Notice> {
        let mut news = self.news();
        let mut notices = Vec::new();
        let ids = |jobs: &mut HashSet<JobId>, make: fn(Vec<JobId>) -> Notice| {
            (!jobs.is_empty()).then(|| make(jobs.drain().collect()))
        };
        if std::mem::take(&mut news.queued) {
            notices.push(Notice::Queued);
        }
        notices.extend(ids(&mut news.stopped, Notice::Stopped));
        notices.extend(ids(&mut news.followed, Notice::Followed));
        if with_progress {
            let progress = news.progress.drain();
            notices.extend(
                progress.map(|(job, (revision, progress))| Notice::Progress {
                    job,
                    revision,
                    progress,
                }),
            );
        }
        // Last: what is told of a run is not to come behind its end.
        notices.extend(ids(&mut news.changed, Notice::Changed));
        notices
    }

    /// Jobs wait.
    pub fn queued(&self) {
        self.news().queued = true;
        self.0.some.notify_one();
    }

    /// A job was cancelled or forgotten.
    pub fn stopped(&self, job: JobId) {
        let mut news = self.news();
        news.stopped.insert(job);
        news.changed.insert(job);
        self.0.some.notify_one();
    }

    /// The record of a job has changed, which is told where somebody waits for it.
    pub fn changed(&self, job: JobId) {
        if self.is_followed(job) {
            let mut news = self.news();
            news.progress.remove(&job);
            news.changed.insert(job);
            self.0.some.notify_one();
        }
    }

    /// A run stands so, which is told where somebody waits for it.
    pub fn progressed(&self, job: JobId, revision: u64, progress: &Progress) {
        if self.is_followed(job) {
            let mut news = self.news();
            let first = news.progress.is_empty();
            news.progress.insert(job, (revision, progress.clone()));
            if first {
                self.0.some.notify_one();
            }
        }
    }

    /// Somebody here waits for a job.
    pub fn follow(&self, job: JobId) {
        let mut news = self.news();
        let now = Instant::now();
        let asked = news.asked.get(&job);
        if asked.is_some_and(|asked| now.duration_since(*asked) < FOLLOW_AGAIN) {
            return;
        }
        // Now and then, and not more than these are many.
        if news.asked.len() >= MAX_FOLLOWED {
            news.asked
                .retain(|_, asked| now.duration_since(*asked) < FOLLOW_AGAIN);
        }
        news.asked.insert(job, now);
        news.followed.insert(job);
        self.0.some.notify_one();
    }

    /// Somebody elsewhere waits for these jobs.
    pub fn heard_of_followers(&self, jobs: &[JobId]) {
        let now = Instant::now();
        let mut followed = self.followed();
        followed.extend(jobs.iter().map(|job| (*job, now)));
        if followed.len() > MAX_FOLLOWED {
            followed.retain(|_, heard| now.duration_since(*heard) < FOLLOW_TIME);
        }
        // More than anyone can wait for: they find it in the store.
        if followed.len() > MAX_FOLLOWED {
            followed.clear();
        }
    }

    fn is_followed(&self, job: JobId) -> bool {
        let followed = self.followed();
        let heard = followed.get(&job);
        heard.is_some_and(|heard| heard.elapsed() < FOLLOW_TIME)
    }

    fn news(&self) -> MutexGuard<'_, News> {
        self.0.news.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn followed(&self) -> MutexGuard<'_, HashMap<JobId, Instant>> {
        self.0
            .followed
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}
