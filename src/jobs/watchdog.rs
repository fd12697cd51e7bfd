//! Sees to it that a job ends when it has to, whatever its run or the store does.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{MissedTickBehavior, interval};

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

/// Looks after the runs until the server stops. Never waits for the store, so that one which does not answer
/// keeps nothing else from being seen to.
///
/// A run that does not heed a cancellation has its job cancelled over its head. One that goes on after its
/// time has it failed, and another worker takes the place of its own. While the process takes more
/// memory than it may, nothing new is begun and runs are stopped, the last one to start first: while there
/// are others it goes back to the queue, alone it fails.
pub async fn watch(crew: Arc<Crew>) {
    let shared = Arc::clone(crew.shared());
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
            // Another may be given the job.
            if shared
                .fence
                .is_some_and(|fence| control.unrenewed() >= fence)
            {
                control.raise(Stop::Release);
            }
            let overtime = control.look(preparing);
            let cancelled = control.cancelled_for();
            if cancelled.is_some_and(|time| time >= CANCEL_TIME) {
                overrule(&shared, &control, Some(Ending::Nothing));
            }
            if overtime >= GRACE_LOOKS {
                // Whoever is to put its job back may only be waiting for the store.
                match control.stop() {
                    Some(Stop::Release) => overrule(&shared, &control, None),
                    _ => overrule(&shared, &control, Some(Ending::Problem(runaway()))),
                }
                if control.is_overruled() {
                    crew.replace(&control);
                }
            }
        }
        if shared.memory.look() {
            save_memory(&shared);
        }
    }
}

/// Whether the worker of a run that does not end has not been replaced, because too many were.
pub fn is_stuck(control: &Control) -> bool {
    control.overtime() > GRACE_LOOKS && control.is_overruled()
}

/// Ends a job, or without an `ending` puts it back, without waiting for its run, unless that is being done. While the store fails it is tried again
/// until the server stops; the next start takes the job up then.
fn overrule(shared: &Arc<Shared>, control: &Arc<Control>, ending: Option<Ending>) {
    if !control.begin_overruling() {
        return;
    }
    // Whatever the store does: the run is of no use any more.
    control.raise(Stop::Discard);
    let (shared, control) = (Arc::clone(shared), Arc::clone(control));
    tokio::spawn(async move {
        let (store, job) = (&shared.store, control.lease.job);
        let (revision, progress) = control.close();
        let mut over = shared.stopping.is_cancelled();
        while !over {
            let lease = &control.lease;
            let written = match &ending {
                Some(ending) => store.finish(lease, ending, &progress, revision).await,
                None => store.release(lease, revision).await,
            };
            match written {
                Ok(true) => {
                    let end = match ending {
                        None => RunEnd::Released,
                        Some(Ending::Nothing) => RunEnd::Cancelled,
                        Some(Ending::Problem(_) | Ending::Result(_)) => RunEnd::Failed,
                    };
                    shared.metrics.jobs.ended(end, control.entered.elapsed());
                    tracing::warn!(%job, "a run does not end by itself; its job was ended");
                    break;
                }
                Ok(false) => {
                    tracing::info!(%job, "the job was ended or forgotten meanwhile");
                    break;
                }
                Err(error) => tracing::error!(%job, %error, "the end of a job cannot be stored"),
            }
            shared.pause().await;
            over = shared.stopping.is_cancelled();
        }
        control.overrule();
        shared.changes.stored(job);
    });
}

/// Lets go of what can be had again, and stops one run if none is about to end.
fn save_memory(shared: &Arc<Shared>) {
    shared.meshes.clear();
    let runs = shared.running.all();
    let ends = |control: &Arc<Control>| control.is_ending();
    if runs
        .iter()
        .any(|control| ends(control) && control.overtime() < FREE_LOOKS)
    {
        return;
    }
    let mut runs: Vec<_> = runs.iter().filter(|control| !ends(control)).collect();
    runs.sort_by_key(|control| control.entered);
    match runs[..] {
        [] => {}
        [alone] => {
            let problem = out_of_memory(shared.memory.limit());
            overrule(shared, alone, Some(Ending::Problem(problem)));
        }
        // It need not be the one that takes so much: it begins again once there is room.
        [.., last] => last.raise(Stop::Release),
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
            "the server came to its limit of {limit} MiB while this job ran alone; try a \
             coarser mesh, fewer candidates or a smaller population, let fewer jobs run at a time \
             (--workers), or allow more memory (--max-memory)"
        ),
    )
}
