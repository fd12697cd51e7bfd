//! The bounded pool of workers and its end.

use std::sync::Arc;
use std::time::{Duration, Instant};

use futures_util::future::join_all;
use tokio::time::{sleep, timeout};
use tokio_util::sync::CancellationToken;

use super::context::Context;
use super::control::Control;
use super::error::StartError;
use super::watchdog;
use super::workers::Workers;
use crate::cluster::RunStop;

/// Time between two looks whether all runs have ended.
const DRAIN_LOOK: Duration = Duration::from_millis(20);
/// Time between two looks whether all threads have ended.
const STOP_LOOK: Duration = Duration::from_millis(5);
/// Longest time to wait for the store when jobs go back to the queue at a shutdown.
const LAST_RELEASES: Duration = Duration::from_secs(3);

/// The workers and their watchdog. Dropping it makes them put their jobs back and end.
pub struct Pool(Arc<Workers>);

impl Pool {
    /// Starts `workers` threads, each planning on `threads_per_job` threads of its own.
    pub fn start(
        context: Arc<Context>,
        workers: usize,
        threads_per_job: usize,
    ) -> Result<Self, StartError> {
        let workers = Arc::new(Workers::start(context, workers, threads_per_job)?);
        tokio::spawn(watchdog::watch(Arc::clone(&workers)));
        Ok(Self(workers))
    }

    /// Returns whether a slot has no worker although the process goes on: its thread has ended, or is lost in a run that
    /// does not end.
    pub fn has_lost_workers(&self) -> bool {
        let Context {
            lifecycle, running, ..
        } = &**self.0.context();
        let is_stuck = |control: &Arc<Control>| watchdog::is_stuck(control);
        !lifecycle.stopping.is_cancelled()
            && (self.0.any_has_ended() || running.all().iter().any(is_stuck))
    }

    /// Begins no job any more, and waits for those that run to end, for `time` at most or until `hurry`.
    pub async fn drain(&self, time: Duration, hurry: &CancellationToken) {
        let context = self.0.context();
        context.lifecycle.closing.cancel();
        let ended = async {
            while !context.running.is_empty() {
                sleep(DRAIN_LOOK).await;
            }
        };
        let _ = hurry.run_until_cancelled(timeout(time, ended)).await;
    }

    /// Makes all runs put their jobs back and waits for the threads to end, for `grace` at most; the jobs of those that
    /// have not ended by then are put back without them.
    pub async fn stop(&self, grace: Duration) {
        self.request_stop();
        let deadline = Instant::now() + grace;
        let context = self.0.context();
        while !self.0.all_have_ended() && Instant::now() < deadline {
            sleep(STOP_LOOK).await;
        }
        let stuck = context.running.all();
        let releases = stuck.iter().map(|control| {
            let held = &control.held;
            tracing::warn!(job = %held.lease.job, "a run does not stop; its job is put back regardless");
            let (revision, _) = held.close();
            context.queue.put_back(&held.lease, revision)
        });
        let last = async { tokio::join!(join_all(releases), context.queue.end()) };
        if timeout(LAST_RELEASES, last).await.is_err() {
            tracing::error!(
                "the store does not answer; another process or the next start puts the jobs back"
            );
        }
        context.lifecycle.ended.cancel();
    }

    fn request_stop(&self) {
        let context = self.0.context();
        context.lifecycle.closing.cancel();
        // In this order: a worker enters its run first and looks at the token then.
        context.lifecycle.stopping.cancel();
        for control in context.running.all() {
            control.request_stop(RunStop::Release);
        }
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.request_stop();
        self.0.context().lifecycle.ended.cancel();
    }
}
