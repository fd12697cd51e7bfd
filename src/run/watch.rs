//! The clock beside a run: it dates the progress, ends the run when its time is over, and repeats the progress
//! during long steps.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::wire::{PlanRequest, Progress};
use graspd_core::search::{Phase, SearchProgress};
use graspd_core::{Interrupt, Interrupted};

/// Time without news after which the last progress is reported again, with the time that has passed since.
const REPEAT_AFTER: Duration = Duration::from_millis(50);

/// Watches one run on behalf of whoever asked for it.
pub(super) struct Watch<'a> {
    clock: Instant,
    limit: Option<Duration>,
    generations: u64,
    /// Where the run is cancelled.
    interrupt: Interrupt<'a>,
    news: Mutex<News<'a>>,
}

struct News<'a> {
    observe: &'a mut (dyn FnMut(&Progress) + Send),
    latest: Option<Progress>,
    reported: Duration,
    /// When the time that is limited began: the search and what follows it each have the whole limit.
    begun: Duration,
    /// When each generation ended, in seconds.
    ended: Vec<f64>,
}

impl<'a> Watch<'a> {
    /// Starts the clock.
    pub(super) fn start(
        request: &PlanRequest,
        interrupt: Interrupt<'a>,
        observe: &'a mut (dyn FnMut(&Progress) + Send),
    ) -> Self {
        Self {
            clock: Instant::now(),
            limit: request.time_limit_s.map(Duration::from_secs_f64),
            generations: u64::from(request.generations),
            interrupt,
            news: Mutex::new(News {
                observe,
                latest: None,
                reported: Duration::ZERO,
                begun: Duration::ZERO,
                ended: Vec::new(),
            }),
        }
    }

    /// Reports progress of the planner.
    pub(super) fn report(&self, progress: &SearchProgress<'_>) {
        let elapsed = self.clock.elapsed();
        let mut news = self.news.lock().unwrap_or_else(PoisonError::into_inner);
        if progress.generation_ended {
            news.ended.push(elapsed.as_secs_f64());
        }
        let phase = progress.phase;
        let latest = news.latest.take();
        if phase == Phase::Analysis && latest.as_ref().is_none_or(|latest| latest.phase != phase) {
            news.begun = elapsed;
        }
        let best_contacts = match progress.grasp {
            Some(grasp) => Some(grasp.contacts()),
            // Not all steps of the planner name the grasp.
            None => latest.and_then(|latest| latest.best_contacts),
        };
        news.publish(Progress {
            phase,
            generation: progress.generation as u64,
            generations: self.generations,
            evaluations: progress.evaluations,
            best_quality: progress.best,
            best_contacts,
            elapsed_s: elapsed.as_secs_f64(),
        });
    }

    /// Whether the run is to stop. A cancellation counts more than the time limit.
    pub(super) fn interrupted(&self) -> Option<Interrupted> {
        if let Err(why) = self.interrupt.check() {
            return Some(why);
        }
        let elapsed = self.clock.elapsed();
        // Another thread that has the lock reports or repeats just now.
        let mut news = self.news.try_lock().ok()?;
        if self
            .limit
            .is_some_and(|limit| elapsed - news.begun >= limit)
        {
            return Some(Interrupted::TimeLimit);
        }
        if elapsed - news.reported >= REPEAT_AFTER
            && let Some(latest) = news.latest.take()
        {
            news.publish(Progress {
                elapsed_s: elapsed.as_secs_f64(),
                ..latest
            });
        }
        None
    }

    /// How long the run took, and when each generation ended, in seconds.
    pub(super) fn end(self) -> (Duration, Vec<f64>) {
        let news = self.news.into_inner();
        let news = news.unwrap_or_else(PoisonError::into_inner);
        (self.clock.elapsed(), news.ended)
    }
}

impl News<'_> {
    fn publish(&mut self, progress: Progress) {
        self.reported = Duration::from_secs_f64(progress.elapsed_s);
        (self.observe)(&progress);
        self.latest = Some(progress);
    }
}
