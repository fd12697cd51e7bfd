//! Sees to it that a job ends when it has to, whatever its run does.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{MissedTickBehavior, interval, sleep};

use super::control::{Control, Stop};
use super::pool::{Crew, Shared};
use crate::metrics::RunEnd;
use crate::store::Ending;
use crate::wire::Problem;

/// Time between two looks.
const EVERY: Duration = Duration::from_millis(25);
/// How long a cancelled run has to hand in what it found: a cancellation is to take effect within 0.2 s,
/// and a look and a write come behind this.
const CANCEL_TIME: Duration = Duration::from_millis(120);
/// Looks until the memory of a run that was stopped ought to be free, 1 s.
const FREE_LOOKS: u32 = 40;
/// Looks until a run that was to end is given up, 5 s.
const GRACE_LOOKS: u32 = 200;
/// Pause after the store failed.
const STORE_PAUSE: Duration = Duration::from_secs(1);

/// Looks after the runs until the server stops.
///
/// A run that does not heed a cancellation has its job cancelled over its head. One that goes on after its
/// time has it failed, and another worker takes the place of its own. While the process takes more
/// memory than it may, nothing new is begun and the run that started last is stopped.
pub async fn watch(crew: Arc<Crew>) {
    let shared = crew.shared();
    let preparing = shared.limits.time.saturating_mul(2);
    let mut looks = interval(EVERY);
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    while shared
        .stopping
        .run_until_cancelled(looks.tick())
        .await
        .is_some()
    {
        for control in shared.running.all() {
            let overtime = control.look(preparing);
            let cancelled = control.cancelled_for();
            if cancelled.is_some_and(|time| time >= CANCEL_TIME) {
                overrule(shared, &control, Ending::Nothing).await;
            }
            if overtime >= GRACE_LOOKS {
                overrule(shared, &control, Ending::Problem(runaway())).await;
                crew.replace(&control);
            }
        }
        if shared.memory.look() {
            save_memory(shared).await;
        }
    }
}

/// Whether the worker of a run that does not end has not been replaced, because too many were.
pub fn is_stuck(control: &Control) -> bool {
    control.overtime() > GRACE_LOOKS
}

/// Ends a job without waiting for its run.
async fn overrule(shared: &Shared, control: &Control, ending: Ending) {
    if control.is_overruled() {
        return;
    }
    let job = control.lease.job;
    let (revision, progress) = control.close();
    let store = &shared.store;
    let finish = || store.finish(&control.lease, &ending, &progress, revision);
    match store.with_reserve(finish).await {
        Ok(true) => {
            let end = match ending {
                Ending::Nothing => RunEnd::Cancelled,
                Ending::Problem(_) | Ending::Result(_) => RunEnd::Failed,
            };
            shared.metrics.jobs.ended(end, control.entered.elapsed());
            tracing::warn!(%job, "a run does not end by itself; its job was ended");
        }
        Ok(false) => tracing::info!(%job, "the job was ended or forgotten meanwhile"),
        Err(error) => {
            tracing::error!(%job, %error, "the end of a job cannot be stored");
            return sleep(STORE_PAUSE).await;
        }
    }
    control.overrule();
    control.raise(Stop::Discard);
    shared.changes.stored(job);
}

/// Lets go of what can be had again, and stops one run if none is about to end.
async fn save_memory(shared: &Shared) {
    shared.meshes.clear();
    let runs = shared.running.all();
    let waits = |control: &Arc<Control>| control.is_overruled() && control.overtime() < FREE_LOOKS;
    if runs.iter().any(waits) {
        return;
    }
    let runs = runs.iter().filter(|control| !control.is_overruled());
    if let Some(last) = runs.max_by_key(|control| control.entered) {
        let problem = out_of_memory(shared.memory.limit());
        overrule(shared, last, Ending::Problem(problem)).await;
    }
}

fn runaway() -> Problem {
    Problem::new(
        500,
        "runaway",
        "The run did not end",
        "the run went on after its time was over and was given up; this is a fault of the server: submit \
         the job again with other settings or a coarser mesh, and report it",
    )
}

fn out_of_memory(limit: Option<u64>) -> Problem {
    let limit = limit.unwrap_or_default() >> 20;
    Problem::new(
        500,
        "out-of-memory",
        "Out of memory",
        format!(
            "the server came to its limit of {limit} MiB while this job, the last to start, ran; try a \
             coarser mesh, fewer candidates or a smaller population, let fewer jobs run at a time \
             (--workers), or allow more memory (--max-memory)"
        ),
    )
}
