//! One run of a job, from its claim to its outcome.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rayon::ThreadPool;
use serde_json::value::RawValue;
use tokio::runtime::Handle;
use uuid::Uuid;

use super::context::Context;
use super::control::Control;
use super::ingest;
use super::observer::Observer;
use crate::cluster::RunStop;
use crate::store::{Owner, RunOutcome, StoreError};
use crate::wire::{MeshId, PlanRequest, Problem, Progress};
use graspd_core::mesh::Mesh;
use graspd_core::{Interrupt, Interrupted};

/// The outcome of a run.
pub enum Outcome {
    Ended(RunOutcome),
    /// It was stopped before its end, with what was found so far.
    Stopped(Option<Box<RawValue>>),
}

/// A run about to begin. Its methods block.
pub struct Run<'a> {
    pub context: &'a Context,
    pub control: &'a Control,
    pub owner: &'a Owner,
    pub mesh_id: &'a MeshId,
    /// The settings, as JSON.
    pub request: &'a str,
    /// The threads that plan.
    pub planners: &'a ThreadPool,
    /// The runtime of the store.
    pub runtime: &'a Handle,
}

impl Run<'_> {
    /// Plans the job. A panic fails it, and nothing else.
    pub fn carry_out(&self, clock: Instant) -> Outcome {
        match guarded(|| self.measured(clock)) {
            Ok(outcome) => outcome,
            Err(panic) => {
                self.context.metrics.jobs.panics.inc();
                let problem = internal_error(&*panic);
                // The payload may panic again when it is dropped.
                let _ = guarded(|| drop(panic));
                Outcome::Ended(RunOutcome::Problem(problem))
            }
        }
    }

    fn measured(&self, clock: Instant) -> Outcome {
        let context = self.context;
        let held = &self.control.held;
        let job = held.lease.job;
        context.metrics.jobs.started(job.age());
        // The run is entered by now: whoever stops the process from here on finds it.
        if context.lifecycle.stopping.is_cancelled() {
            held.request_stop(RunStop::Release);
        }
        // Whoever cancelled the job between its claim and its entry did not find the run.
        if context.changes.coordinator().may_be_stopped(job) {
            self.runtime.block_on(held.check(&context.store));
        }
        tracing::info!("job starts");
        let span = tracing::Span::current();
        let outcome = self.planners.install(|| span.in_scope(|| self.attempt()));
        context.queue.note_pace(clock.elapsed());
        tracing::info!(elapsed = ?clock.elapsed(), "job leaves its worker");
        outcome
    }

    fn attempt(&self) -> Outcome {
        let Self {
            context, control, ..
        } = self;
        let failed = |problem| Outcome::Ended(RunOutcome::Problem(problem));
        if control.stop_reason().is_some() {
            return Outcome::Stopped(None);
        }
        let request: PlanRequest = match serde_json::from_str(self.request) {
            Ok(request) => request,
            Err(error) => return failed(unreadable_request(&error)),
        };
        let mesh = match self.mesh() {
            Ok(Some(mesh)) => mesh,
            Ok(None) => {
                self.runtime.block_on(context.lifecycle.store_pause());
                control.request_stop(RunStop::Release);
                return Outcome::Stopped(None);
            }
            Err(problem) => return failed(problem),
        };
        if control.stop_reason().is_some() {
            return Outcome::Stopped(None);
        }
        control.begin();
        let evaluations = &context.metrics.jobs.evaluations;
        let mut observer = Observer::new(&control.held, &context.changes, evaluations);
        // Set when the run sees that it should stop. One that ends by itself before has its whole result.
        let is_stopped = AtomicBool::new(false);
        let ask = || {
            control.stop_reason().map(|_| {
                is_stopped.store(true, Ordering::Relaxed);
                Interrupted::Cancelled
            })
        };
        let interrupt = Interrupt::new(&ask);
        let mut observe = |progress: &Progress| observer.observe(progress);
        let planned = (context.runner)(&mesh, &request, interrupt, &mut observe);
        observer.end();
        match planned {
            Ok(found) if is_stopped.load(Ordering::Relaxed) => Outcome::Stopped(Some(found)),
            Ok(result) => Outcome::Ended(RunOutcome::Result(result)),
            Err(problem) => failed(problem),
        }
    }

    /// Returns the mesh, from memory or from its file; `None` when a shared store does not deliver it now.
    fn mesh(&self) -> Result<Option<Arc<Mesh>>, Problem> {
        let Context {
            store,
            meshes,
            limits,
            changes,
            ..
        } = self.context;
        let id = self.mesh_id;
        if let Some(mesh) = meshes.get(id) {
            return Ok(Some(mesh));
        }
        let file = match self.runtime.block_on(store.mesh_file(self.owner, id)) {
            Ok(file) => file,
            Err(error) => {
                tracing::error!(mesh = %id, %error, "the file of a mesh cannot be read");
                // A disk that fails here fails for good; a database may be away for a moment.
                let is_passing = !matches!(error, StoreError::Damaged(_));
                if changes.coordinator().is_shared() && is_passing {
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

/// Runs `work` and catches its panic. What the threads share is whole after a panic: locks are held for single steps.
pub fn guarded<T>(work: impl FnOnce() -> T) -> std::thread::Result<T> {
    catch_unwind(AssertUnwindSafe(work))
}

fn unreadable_request(error: &serde_json::Error) -> Problem {
    Problem::new(
        500,
        "unreadable-request",
        "Unreadable request",
        format!(
            "the settings of this job were stored by another version of graspd and cannot be read by this one \
             ({error}); submit the job again"
        ),
    )
}

fn mesh_lost(what: &str) -> Problem {
    Problem::new(
        500,
        "mesh-lost",
        "Mesh lost",
        format!("the file of the mesh {what}; upload it again and submit the job again"),
    )
}

fn internal_error(panic: &(dyn Any + Send)) -> Problem {
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
        format!("a fault of the server; its log has the cause under the id {incident}"),
    )
}
