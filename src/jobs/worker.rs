//! One worker: takes a job off the queue, plans, writes down what became of it.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

use rayon::ThreadPool;
use serde_json::value::RawValue;
use tokio::runtime::Handle;
use tokio::task::JoinHandle;
use tracing::Instrument;
use uuid::Uuid;

use super::control::{Control, Observer, Stop};
use super::ingest;
use super::pool::{STORE_PAUSE, Shared};
use super::running::Running;
use crate::metrics::RunEnd;
use crate::store::{Claim, Ending, Owner, StoreError};
use crate::wire::{MeshId, PlanRequest, Problem};
use graspd_core::mesh::Mesh;

/// What one worker thread has.
pub struct Worker {
    /// Its number.
    place: usize,
    shared: Arc<Shared>,
    planners: ThreadPool,
    runtime: Handle,
}

/// What became of a run.
enum Run {
    Ended(Ending),
    /// Told to stop before its end, with what was found so far.
    Stopped(Option<Box<RawValue>>),
}

impl Worker {
    pub fn new(place: usize, shared: Arc<Shared>, planners: ThreadPool, runtime: Handle) -> Self {
        Self {
            place,
            shared,
            planners,
            runtime,
        }
    }

    /// Runs jobs, one after the other, until the server stops or another worker has its place.
    pub fn work(&self) {
        let mut settling = None;
        loop {
            match guarded(|| self.runtime.block_on(self.next())) {
                Ok(Some((claim, asked))) => {
                    if !self.run(claim, asked, &mut settling) {
                        break;
                    }
                }
                Ok(None) => break,
                // Whatever it was, do not run into it at full speed.
                Err(_) => std::thread::sleep(STORE_PAUSE),
            }
        }
        self.settled(&mut settling);
    }

    /// The next job and when it was asked for, or `None` when no job is begun any more.
    async fn next(&self) -> Option<(Claim, Instant)> {
        let shared = &*self.shared;
        let Shared {
            queued,
            closing,
            memory,
            ..
        } = shared;
        while !closing.is_cancelled() {
            // What starts now would be the first to be stopped.
            if memory.is_over() {
                shared.pause().await;
                continue;
            }
            match self.claim().await {
                Ok(Some(claim)) => {
                    // One wake-up is remembered however many jobs came; pass it on.
                    queued.notify_one();
                    shared.ahead.ask(&self.shared);
                    return Some(claim);
                }
                Ok(None) => {
                    let _ = closing.run_until_cancelled(queued.notified()).await;
                }
                Err(error) => {
                    tracing::error!(%error, "the queue cannot be read");
                    shared.pause().await;
                }
            }
        }
        None
    }

    /// The next job, if there is one, and when it was asked for.
    async fn claim(&self) -> Result<Option<(Claim, Instant)>, StoreError> {
        if let Some(claim) = self.shared.ahead.take() {
            return Ok(Some(claim));
        }
        let asked = Instant::now();
        let claim = self.shared.claim().await?;
        Ok(claim.map(|claim| (claim, asked)))
    }

    /// Runs a job to its end, whatever panics on the way. Says whether the worker still has its place.
    fn run(&self, claim: Claim, asked: Instant, settling: &mut Option<JoinHandle<()>>) -> bool {
        let Claim {
            lease,
            owner,
            mesh_id,
            request,
            revision,
        } = claim;
        let span = tracing::info_span!("run", job = %lease.job, mesh = %mesh_id);
        let _inside = span.enter();
        let running = &self.shared.running;
        let control = running.enter(self.place, lease, asked, revision, &request);
        let clock = Instant::now();
        let mesh = (&owner, &mesh_id);
        let run = match guarded(|| self.carry_out(&control, mesh, &request, clock)) {
            Ok(run) => run,
            Err(panic) => {
                self.shared.metrics.jobs.panics.inc();
                let failed = Run::Ended(Ending::Problem(bug(&*panic)));
                // What was thrown may panic once more when it is dropped.
                let _ = guarded(|| drop(panic));
                failed
            }
        };
        let has_place = running.come_back(&control);
        // One at a time: while the store fails, jobs are not to pile up that have ended.
        self.settled(settling);
        let shared = Arc::clone(&self.shared);
        let settle = async move { settle(&shared, &control, run, clock).await };
        *settling = Some(self.runtime.spawn(settle.in_current_span()));
        // Where others share the store, a statement takes a while: the next job is asked for meanwhile.
        if self.shared.fence.is_none() {
            self.settled(settling);
        }
        has_place
    }

    /// Waits until what became of the last run is written down.
    fn settled(&self, settling: &mut Option<JoinHandle<()>>) {
        if let Some(settling) = settling.take()
            && self.runtime.block_on(settling).is_err()
        {
            tracing::error!("what became of a run was lost by a panic");
        }
    }

    fn carry_out(
        &self,
        control: &Control,
        mesh: (&Owner, &MeshId),
        request: &str,
        clock: Instant,
    ) -> Run {
        let shared = &*self.shared;
        let job = control.lease.job;
        shared.metrics.jobs.started(job.age());
        if shared.stopping.is_cancelled() {
            control.raise(Stop::Release);
        }
        // A cancellation that came between the claim and the entry is in the row only, and where processes tell each
        // other of it, it was heard.
        if shared.fence.is_none() || shared.running.is_expected_to_stop(job) {
            self.runtime.block_on(shared.look_at_hold(control));
        }
        tracing::info!("job starts");
        let span = tracing::Span::current();
        let run = self
            .planners
            .install(|| span.in_scope(|| self.attempt(control, mesh, request)));
        shared.note_pace(clock.elapsed());
        tracing::info!(elapsed = ?clock.elapsed(), "job leaves its worker");
        run
    }

    fn attempt(&self, control: &Control, mesh: (&Owner, &MeshId), request: &str) -> Run {
        let failed = |problem| Run::Ended(Ending::Problem(problem));
        if control.stop().is_some() {
            return Run::Stopped(None);
        }
        let request: PlanRequest = match serde_json::from_str(request) {
            Ok(request) => request,
            Err(error) => {
                return failed(Problem::new(
                    500,
                    "unreadable-request",
                    "Unreadable request",
                    format!(
                        "the settings of this job were stored by another version of graspd and \
                         cannot be read by this one ({error}); submit the job again"
                    ),
                ));
            }
        };
        let mesh = match self.mesh(mesh) {
            Ok(Some(mesh)) => mesh,
            Ok(None) => {
                self.runtime.block_on(self.shared.pause());
                control.raise(Stop::Release);
                return Run::Stopped(None);
            }
            Err(problem) => return failed(problem),
        };
        if control.stop().is_some() {
            return Run::Stopped(None);
        }
        control.begin();
        let mut observer = Observer::new(control, &self.shared.metrics.jobs.evaluations);
        let outcome =
            (self.shared.runner)(&mesh, &request, &mut |progress| observer.note(progress));
        let stopped = observer.end();
        match outcome {
            Ok(found) if stopped => Run::Stopped(Some(found)),
            Ok(result) => Run::Ended(Ending::Result(result)),
            Err(problem) => failed(problem),
        }
    }

    /// A mesh from memory or, else, from its file; `None` when a shared store does not give it now. Blocks.
    fn mesh(&self, (owner, id): (&Owner, &MeshId)) -> Result<Option<Arc<Mesh>>, Problem> {
        let Shared {
            store,
            meshes,
            limits,
            ..
        } = &*self.shared;
        if let Some(mesh) = meshes.get(id) {
            return Ok(Some(mesh));
        }
        let file = match self.runtime.block_on(store.mesh_file(owner, id)) {
            Ok(file) => file,
            Err(error) => {
                tracing::error!(mesh = %id, %error, "the file of a mesh cannot be read");
                // A disk that fails here fails for good; a database may be away for a moment.
                let is_passing = !matches!(error, StoreError::Damaged(_));
                if self.shared.fence.is_some() && is_passing {
                    return Ok(None);
                }
                return Err(mesh_lost("cannot be read"));
            }
        };
        let (options, bytes) = file.ok_or_else(|| mesh_lost("is gone"))?;
        let (_, mesh) = ingest::prepare_mesh(bytes, &options, limits)?;
        let mesh = Arc::new(mesh);
        meshes.put(id.clone(), Arc::clone(&mesh));
        Ok(Some(mesh))
    }
}

/// Writes down what became of a run. While the store fails, tries until the server stops;
/// then the next start takes the job up again.
async fn settle(shared: &Shared, control: &Arc<Control>, run: Run, clock: Instant) {
    let Shared {
        store,
        changes,
        stopping,
        metrics,
        ..
    } = shared;
    let _leaving = Leaving(&shared.running, control);
    let Control { lease, .. } = &**control;
    let ended = |end| metrics.jobs.ended(end, clock.elapsed());
    let ending = match (run, control.stop()) {
        // Whoever ended the job over its head has counted it.
        (_, Some(Stop::Discard)) if control.is_overruled() => return,
        (_, Some(Stop::Discard)) => return ended(RunEnd::Abandoned),
        (Run::Stopped(_), Some(Stop::Release)) => None,
        (Run::Stopped(found), _) => Some(found.map_or(Ending::Nothing, Ending::Result)),
        (Run::Ended(ending), _) => Some(ending),
    };
    let end = match (&ending, control.stop()) {
        (None, _) => RunEnd::Released,
        (Some(Ending::Problem(_)), _) => RunEnd::Failed,
        (Some(Ending::Nothing), _) | (_, Some(Stop::Cancel)) => RunEnd::Cancelled,
        (Some(Ending::Result(_)), _) => RunEnd::Succeeded,
    };
    let (revision, progress) = control.close();
    loop {
        let written = match &ending {
            Some(ending) => store.finish(lease, ending, &progress, revision).await,
            None => store.release(lease, revision).await,
        };
        match written {
            Ok(true) => {
                ended(end);
                if end == RunEnd::Released {
                    shared.tell_queued();
                }
                return changes.stored(lease.job);
            }
            Ok(false) => {
                ended(RunEnd::Abandoned);
                return tracing::info!("the job was ended or forgotten meanwhile");
            }
            Err(error) => tracing::error!(%error, "the end of a job cannot be stored"),
        }
        if stopping.is_cancelled() {
            return;
        }
        shared.pause().await;
    }
}

/// Takes a run out of those that run here, however its settling ends.
struct Leaving<'a>(&'a Running, &'a Arc<Control>);

impl Drop for Leaving<'_> {
    fn drop(&mut self) {
        self.0.leave(self.1);
    }
}

fn mesh_lost(what: &str) -> Problem {
    Problem::new(
        500,
        "mesh-lost",
        "Mesh lost",
        format!("the file of the mesh {what}; upload it again and submit the job again"),
    )
}

/// Runs `work` and catches its panic. What the workers share is whole after a panic: locks are
/// taken for single steps only.
fn guarded<T>(work: impl FnOnce() -> T) -> std::thread::Result<T> {
    catch_unwind(AssertUnwindSafe(work))
}

fn bug(panic: &(dyn Any + Send)) -> Problem {
    let incident = Uuid::new_v4();
    let message = panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message");
    // The log may be what panicked.
    let _ = guarded(|| tracing::error!(%incident, cause = message, "a run panicked"));
    Problem::new(
        500,
        "internal-error",
        "Internal error",
        format!("a fault of the server; its log tells more under the id {incident}"),
    )
}
