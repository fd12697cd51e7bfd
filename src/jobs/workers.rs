//! The worker threads.

use std::fmt::Display;
use std::sync::Arc;
use std::thread::JoinHandle;

use parking_lot::Mutex;
use rayon::ThreadPoolBuilder;
use tokio::runtime::Handle;

use super::context::Context;
use super::control::Control;
use super::error::StartError;
use super::worker::Worker;

/// A fixed number of places, each with one worker thread.
pub struct Workers {
    context: Arc<Context>,
    threads_per_job: usize,
    runtime: Handle,
    /// `None` for a place whose worker could not be replaced.
    threads: Mutex<Vec<Option<JoinHandle<()>>>>,
}

impl Workers {
    /// Starts so many workers, each planning on `threads_per_job` threads of its own.
    pub fn start(
        context: Arc<Context>,
        workers: usize,
        threads_per_job: usize,
    ) -> Result<Self, StartError> {
        let started = Self {
            context,
            threads_per_job,
            runtime: Handle::current(),
            threads: Mutex::default(),
        };
        for number in 0..workers {
            let thread = started.spawn_worker(number)?;
            started.threads.lock().push(Some(thread));
        }
        Ok(started)
    }

    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// Whether the thread of some worker has ended.
    pub fn any_has_ended(&self) -> bool {
        self.threads.lock().iter().any(has_ended)
    }

    /// Whether the threads of all workers have ended.
    pub fn all_have_ended(&self) -> bool {
        self.threads.lock().iter().all(has_ended)
    }

    /// Abandons a run that does not return, if that may be, and starts another worker in the place of its own, whose
    /// thread ends when the run does.
    pub fn replace(&self, control: &Arc<Control>) {
        if !self.context.running.abandon(control) {
            return;
        }
        let (place, job) = (control.worker, control.held.lease.job);
        tracing::error!(%job, place, "a run was given up; another worker takes its place");
        let thread = self.spawn_worker(place);
        if let Err(error) = &thread {
            tracing::error!(place, %error, "a place stays without a worker");
        }
        if let Some(taken) = self.threads.lock().get_mut(place) {
            *taken = thread.ok();
        }
    }

    fn spawn_worker(&self, number: usize) -> Result<JoinHandle<()>, StartError> {
        let failed = |error: &dyn Display| StartError::Threads(error.to_string());
        let planners = ThreadPoolBuilder::new()
            .num_threads(self.threads_per_job)
            .thread_name(move |thread| format!("plan-{number}-{thread}"))
            .build()
            .map_err(|error| failed(&error))?;
        let worker = Worker {
            number,
            context: Arc::clone(&self.context),
            planners,
            runtime: self.runtime.clone(),
        };
        std::thread::Builder::new()
            .name(format!("worker-{number}"))
            .spawn(move || worker.work())
            .map_err(|error| failed(&error))
    }
}

fn has_ended(thread: &Option<JoinHandle<()>>) -> bool {
    thread.as_ref().is_none_or(JoinHandle::is_finished)
}
