//! Writes the end of a job.

use std::sync::Arc;
use std::time::Instant;

use super::context::Context;
use super::control::Control;
use super::run::Outcome;
use super::running::Running;
use crate::cluster::RunStop;
use crate::metrics::RunEnd;
use crate::store::RunOutcome;

/// Writes the outcome of a run and removes it from those that run here.
pub async fn settle(context: &Context, control: &Arc<Control>, outcome: Outcome, clock: Instant) {
    let _leaving = Leaving(&context.running, control);
    let ended = |end| context.metrics.jobs.ended(end, clock.elapsed());
    let reason = control.stop_reason();
    let ending = match (outcome, reason) {
        // Whoever overruled the run has counted it.
        (_, Some(RunStop::Discard)) if control.is_overruled() => return,
        (_, Some(RunStop::Discard)) => return ended(RunEnd::Abandoned),
        (Outcome::Stopped(_), Some(RunStop::Release)) => None,
        (Outcome::Stopped(found), _) => {
            Some(found.map_or(RunOutcome::Cancelled, RunOutcome::Result))
        }
        (Outcome::Ended(ending), _) => Some(ending),
    };
    let end = match (run_end(ending.as_ref()), reason) {
        (RunEnd::Succeeded, Some(RunStop::Cancel)) => RunEnd::Cancelled,
        (end, _) => end,
    };
    match write_end(context, control, ending.as_ref()).await {
        Some(true) => {
            ended(end);
            if end == RunEnd::Released {
                context.changes.announce_queued();
            }
            context.changes.announce_record(control.held.lease.job);
        }
        Some(false) => {
            ended(RunEnd::Abandoned);
            tracing::info!("the job was ended or deleted before its run");
        }
        None => {}
    }
}

/// Writes how a job ended, or without an `ending` puts it back, at the revision that clients have seen.
///
/// Returns whether the lease still held; if not, nothing has changed. While the store fails it is tried again until the
/// process stops, `None`: whoever recovers the job then takes it up.
pub async fn write_end(
    context: &Context,
    control: &Control,
    ending: Option<&RunOutcome>,
) -> Option<bool> {
    let lease = &control.held.lease;
    let (revision, progress) = control.held.close();
    loop {
        let written = match ending {
            Some(ending) => {
                let store = &context.store;
                store.finish(lease, ending, &progress, revision).await
            }
            None => context.store.release(lease, revision).await,
        };
        match written {
            Ok(was_held) => return Some(was_held),
            Err(error) => {
                tracing::error!(job = %lease.job, %error, "the end of a job cannot be written");
            }
        }
        if context.lifecycle.stopping.is_cancelled() {
            return None;
        }
        context.lifecycle.store_pause().await;
    }
}

/// Returns how a run is counted that ended so, or without an ending was put back.
pub fn run_end(ending: Option<&RunOutcome>) -> RunEnd {
    match ending {
        None => RunEnd::Released,
        Some(RunOutcome::Cancelled) => RunEnd::Cancelled,
        Some(RunOutcome::Problem(_)) => RunEnd::Failed,
        Some(RunOutcome::Result(_)) => RunEnd::Succeeded,
    }
}

/// Removes a run from those that run here, however its settling ends.
struct Leaving<'a>(&'a Running, &'a Arc<Control>);

impl Drop for Leaving<'_> {
    fn drop(&mut self) {
        self.0.leave(self.1);
    }
}
