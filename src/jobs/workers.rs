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

/// A fixed number of slots, each with one worker thread.
pub struct Workers {
    context: Arc<Context>,
    threads_per_job: usize,
    runtime: Handle,
    /// `None` for a slot whose worker could not be replaced.
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

    /// Returns whether the thread of some worker has ended.
    pub fn any_has_ended(&self) -> bool {
        self.threads.lock().iter().any(has_ended)
    }

    /// Returns whether the threads of all workers have ended.
    pub fn all_have_ended(&self) -> bool {
        self.threads.lock().iter().all(has_ended)
    }

    /// Abandons a run that does not return, if [`Running::abandon`](super::running::Running::abandon) allows it, and
    /// starts another worker in its slot. The thread of the abandoned one ends when its run does.
    pub fn replace(&self, control: &Arc<Control>) {
        if !self.context.running.abandon(control) {
            return;
        }
        let (slot, job) = (control.worker, control.held.lease.job);
        tracing::error!(%job, slot, "a run does not end and was abandoned; another worker takes its slot");
        let thread = self.spawn_worker(slot);
        if let Err(error) = &thread {
            tracing::error!(slot, %error, "a worker cannot be replaced");
        }
        if let Some(old) = self.threads.lock().get_mut(slot) {
            *old = thread.ok();
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
