//! Hears what other processes tell, and looks in the store now and then for what was not heard.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use tokio::time::sleep;

use super::herald::Herald;
use super::pool::Shared;
use crate::store::{Audience, Listener, Notice};
use crate::wire::JobId;

/// Time between two looks for changes of jobs that somebody waits for.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Longest that a queued job waits for an idle worker which was not told.
const QUEUE_EVERY: Duration = Duration::from_secs(2);
/// Pause before the line is tried again after it broke.
const LINE_PAUSE: Duration = Duration::from_secs(1);

/// Hears others until the process stops, over one line after the other.
pub async fn listen(shared: Arc<Shared>, herald: Herald, audience: Audience) {
    let work = async {
        loop {
            match shared.store.listen(audience).await {
                Ok(Some(line)) => {
                    // What was told before is lost.
                    catch_up(&shared);
                    hear(&shared, &herald, line).await;
                }
                Ok(None) => return,
                Err(error) => tracing::debug!(%error, "other processes cannot be heard"),
            }
            sleep(LINE_PAUSE).await;
        }
    };
    let _ = shared.stopping.run_until_cancelled(work).await;
}

async fn hear(shared: &Arc<Shared>, herald: &Herald, mut line: Box<dyn Listener>) {
    loop {
        match line.hear().await {
            Ok(notices) => {
                for notice in notices {
                    take_in(shared, herald, notice);
                }
            }
            Err(error) => return tracing::warn!(%error, "the line to other processes is broken"),
        }
    }
}

fn take_in(shared: &Arc<Shared>, herald: &Herald, notice: Notice) {
    match notice {
        Notice::Queued => shared.queued.notify_one(),
        Notice::Followed(jobs) => herald.heard_of_followers(&jobs),
        Notice::Changed(jobs) => {
            for job in jobs {
                shared.running.forget_elsewhere(job);
                shared.changes.heard(job);
            }
        }
        Notice::Progress {
            job,
            revision,
            progress,
        } => {
            shared.running.hear(job, revision, progress);
            shared.changes.heard_of_run(job);
        }
        Notice::Stopped(jobs) => {
            for job in jobs {
                if let Some(control) = shared.running.expect_stop(job) {
                    let shared = Arc::clone(shared);
                    tokio::spawn(async move { shared.look_at_hold(&control).await });
                }
            }
        }
    }
}

/// Looks after everything that may have happened while nothing was heard.
fn catch_up(shared: &Arc<Shared>) {
    shared.queued.notify_one();
    for job in shared.changes.followed() {
        shared.changes.heard(job);
    }
}

/// Looks in the store now and then until the process stops.
pub async fn look(shared: Arc<Shared>) {
    let work = async {
        let mut known: HashMap<JobId, u64> = HashMap::new();
        let mut queue_in = QUEUE_EVERY;
        loop {
            // Not all processes at the same moment.
            let pause = LOOK_EVERY.mul_f64(0.75 + super::random() / 2.0);
            sleep(pause).await;
            queue_in = match queue_in.checked_sub(pause) {
                Some(left) => left,
                None => {
                    shared.queued.notify_one();
                    QUEUE_EVERY
                }
            };
            let mut followed = shared.changes.followed();
            followed.retain(|job| !shared.running.is_here(*job));
            known.retain(|job, _| followed.contains(job));
            for job in &followed {
                shared.changes.ask(*job);
            }
            look_at(&shared, &followed, &mut known).await;
            shared.running.forget_old();
        }
    };
    let _ = shared.stopping.run_until_cancelled(work).await;
}

/// Tells those who wait for these jobs of what has changed since the last look.
async fn look_at(shared: &Shared, jobs: &[JobId], known: &mut HashMap<JobId, u64>) {
    if jobs.is_empty() {
        return;
    }
    let revisions = match shared.store.revisions(jobs).await {
        Ok(revisions) => revisions,
        Err(error) => {
            return tracing::debug!(%error, "the store cannot be looked at for changes");
        }
    };
    let revisions: HashMap<JobId, u64> = revisions.into_iter().collect();
    for job in jobs {
        let now = revisions.get(job).copied().unwrap_or(0);
        if known.insert(*job, now) != Some(now) {
            shared.changes.heard(*job);
        }
    }
}
