//! A worker takes a job from the queue, plans it, and has its outcome written.

use std::sync::Arc;
use std::time::Instant;

use rayon::ThreadPool;
use tokio::runtime::Handle;
use tokio::task::JoinHandle;
use tracing::Instrument;

use super::context::Context;
use super::lifecycle::Lifecycle;
use super::run::{Run, guarded};
use super::settle::settle;
use crate::cluster::TimedClaim;
use crate::store::Claim;

/// The worker of one thread.
pub struct Worker {
    /// Its slot.
    pub number: usize,
    pub context: Arc<Context>,
    /// The threads that plan its jobs.
    pub planners: ThreadPool,
    pub runtime: Handle,
}

impl Worker {
    /// Runs jobs, one after the other, until the process stops or another worker has its slot.
    pub fn work(&self) {
        let Context { queue, memory, .. } = &*self.context;
        let mut settling = None;
        loop {
            match guarded(|| self.runtime.block_on(queue.next(memory))) {
                Ok(Some(claim)) => {
                    if !self.run(claim, &mut settling) {
                        break;
                    }
                }
                Ok(None) => break,
                // Whatever it was, do not run into it at full speed.
                Err(_) => std::thread::sleep(Lifecycle::STORE_PAUSE),
            }
        }
        self.wait_for(&mut settling);
    }

    /// Runs a job to its end. Returns whether the worker still has its slot.
    fn run(&self, claim: TimedClaim, settling: &mut Option<JoinHandle<()>>) -> bool {
        let TimedClaim { claim, asked } = claim;
        let Claim {
            lease,
            owner,
            mesh_id,
            request,
            revision,
        } = claim;
        let span = tracing::info_span!("run", job = %lease.job, mesh = %mesh_id);
        let _inside = span.enter();
        let running = &self.context.running;
        let control = running.enter(self.number, lease, asked, revision, &request);
        let clock = Instant::now();
        let run = Run {
            context: &self.context,
            control: &control,
            owner: &owner,
            mesh_id: &mesh_id,
            request: &request,
            planners: &self.planners,
            runtime: &self.runtime,
        };
        let outcome = run.carry_out(clock);
        let has_slot = running.set_returned(&control);
        // One at a time: while the store fails, jobs that have ended must not pile up.
        self.wait_for(settling);
        let context = Arc::clone(&self.context);
        let settle = async move { settle(&context, &control, outcome, clock).await };
        *settling = Some(self.runtime.spawn(settle.in_current_span()));
        // A statement to a shared store takes a while: the next job is claimed meanwhile.
        if !self.context.changes.coordinator().is_shared() {
            self.wait_for(settling);
        }
        has_slot
    }

    /// Waits until the outcome of the last run is written.
    fn wait_for(&self, settling: &mut Option<JoinHandle<()>>) {
        if let Some(settling) = settling.take()
            && self.runtime.block_on(settling).is_err()
        {
            tracing::error!("the outcome of a run was lost by a panic");
        }
    }
}
