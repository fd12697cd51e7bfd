//! Ends jobs that have to end, whatever their runs or the store do.
//!
//! A run is a thread in the planner. It cannot be killed, only asked, and usually answers within milliseconds. The
//! watchdog checks all runs every 25 ms and acts on those that should have ended:
//!
//! ```text
//! lease not renewed for the fence      ask the run to stop, its job to be released
//! cancelled, and not back in 0.12 s    overrule: cancel the job without the run
//! 200 late checks in a row (5 s)        overrule: fail the job, or release it if that was asked for;
//!                                      then replace the worker
//! memory over its limit                drop the cached meshes; if no run is about to end, release the
//!                                      job of the youngest run, or fail the job of the only one
//! ```
//!
//! It never waits for the store, so a store that does not answer keeps nothing else from being seen to: ends are
//! written by tasks of their own. What a run returns after it was overruled changes nothing, as its lease is gone.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{MissedTickBehavior, interval};

use super::context::Context;
use super::control::Control;
use super::settle::{run_end, write_end};
use super::workers::Workers;
use crate::cluster::RunStop;
use crate::store::RunOutcome;
use crate::wire::Problem;

/// Time between two checks.
const EVERY: Duration = Duration::from_millis(25);
/// How long a cancelled run has to hand in what it found: a cancellation must take effect within 0.2 s, and a check
/// and a write follow.
const CANCEL_TIME: Duration = Duration::from_millis(120);
/// Checks until the memory of a run that was stopped should be free, 1 s.
const FREE_CHECKS: u32 = 40;
/// Checks until a run that should have ended is abandoned, 5 s.
const GRACE_CHECKS: u32 = 200;

/// Watches the runs until the process stops.
pub async fn watch(workers: Arc<Workers>) {
    let context = workers.context();
    let preparing = context.limits.time.saturating_mul(2);
    let mut ticks = interval(EVERY);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let stopping = &context.lifecycle.stopping;
    while stopping.run_until_cancelled(ticks.tick()).await.is_some() {
        for control in context.running.all() {
            check(&workers, &control, preparing);
        }
        if context.memory.measure() {
            save_memory(context);
        }
    }
}

fn check(workers: &Workers, control: &Arc<Control>, preparing: Duration) {
    let context = workers.context();
    // Another process may be given the job.
    let fence = context.changes.coordinator().fence();
    if fence.is_some_and(|fence| control.held.since_renewal() >= fence) {
        control.request_stop(RunStop::Release);
    }
    let overtime = control.check(preparing);
    let cancelled = control.cancelled_for();
    if cancelled.is_some_and(|time| time >= CANCEL_TIME) {
        overrule(context, control, Some(RunOutcome::Cancelled));
    }
    if overtime >= GRACE_CHECKS {
        match control.stop_reason() {
            Some(RunStop::Release) => overrule(context, control, None),
            _ => overrule(context, control, Some(RunOutcome::Problem(runaway()))),
        }
        // Not before the end is written: until then a worker more would be of no use.
        if control.is_overruled() {
            workers.replace(control);
        }
    }
}

/// Returns whether the worker of a run that does not end has not been replaced, because too many were.
pub fn is_stuck(control: &Control) -> bool {
    control.overtime() > GRACE_CHECKS && control.is_overruled()
}

/// Ends a job, or without an `ending` puts it back, without waiting for its run, unless that is being done.
fn overrule(context: &Arc<Context>, control: &Arc<Control>, ending: Option<RunOutcome>) {
    if !control.begin_overruling() {
        return;
    }
    // Whatever the store does: the run is of no use any more.
    control.request_stop(RunStop::Discard);
    let (context, control) = (Arc::clone(context), Arc::clone(control));
    tokio::spawn(async move {
        let held = &control.held;
        let job = held.lease.job;
        match write_end(&context, &control, ending.as_ref()).await {
            Some(true) => {
                let end = run_end(ending.as_ref());
                context.metrics.jobs.ended(end, held.entered.elapsed());
                tracing::warn!(%job, "a run does not end; its job was ended without it");
            }
            Some(false) => tracing::info!(%job, "the job was ended or deleted before its run"),
            None => {}
        }
        control.set_overruled();
        context.changes.announce_record(job);
    });
}

/// Drops what can be loaded again, and stops one run if none is about to end.
fn save_memory(context: &Arc<Context>) {
    context.meshes.clear();
    let runs = context.running.all();
    let is_ending = |control: &Arc<Control>| control.is_ending();
    if runs
        .iter()
        .any(|control| is_ending(control) && control.overtime() < FREE_CHECKS)
    {
        return;
    }
    let mut runs: Vec<_> = runs.iter().filter(|control| !is_ending(control)).collect();
    runs.sort_by_key(|control| control.held.entered);
    match runs[..] {
        [] => {}
        [alone] => {
            let problem = out_of_memory(context.memory.limit());
            overrule(context, alone, Some(RunOutcome::Problem(problem)));
        }
        // It need not be the one that takes so much: it begins again once there is room.
        [.., last] => last.request_stop(RunStop::Release),
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
