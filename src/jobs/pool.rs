//! The bounded pool: threads that take jobs off the queue and plan.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rayon::ThreadPoolBuilder;
use serde_json::value::RawValue;
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio_util::sync::CancellationToken;

use super::cache::MeshCache;
use super::error::StartError;
use super::intake::IntakeLimits;
use super::running::{Running, Stop};
use super::worker::Worker;
use crate::core::mesh::Mesh;
use crate::metrics::Metrics;
use crate::store::Store;
use crate::wire::{PlanRequest, Problem, Progress};

/// Plans a job: mesh, settings, and whom to tell about progress and to ask whether to go on.
/// Answers the result as JSON; when told to stop, with what was found so far.
pub type Runner = dyn Fn(
        &Mesh,
        &PlanRequest,
        &mut (dyn FnMut(&Progress) -> ControlFlow<()> + Send),
    ) -> Result<Box<RawValue>, Problem>
    + Send
    + Sync;

/// What the workers share with the service.
pub struct Shared {
    pub store: Store,
    pub metrics: Metrics,
    pub running: Running,
    pub meshes: MeshCache,
    pub limits: IntakeLimits,
    pub runner: Arc<Runner>,
    /// A job was queued.
    pub queued: Notify,
    pub stopping: CancellationToken,
    /// Moving average of the time one job takes, in microseconds.
    pub pace: AtomicU64,
}

/// The worker threads. Dropping it tells them to put their jobs back and end.
pub struct Pool {
    shared: Arc<Shared>,
    threads: Mutex<Vec<JoinHandle<()>>>,
}

impl Pool {
    /// Starts `workers` threads, each planning on `threads_per_job` threads of its own.
    pub fn start(
        shared: Arc<Shared>,
        workers: usize,
        threads_per_job: usize,
    ) -> Result<Self, StartError> {
        let pool = Self {
            shared,
            threads: Mutex::default(),
        };
        for worker in 0..workers {
            let planners = ThreadPoolBuilder::new()
                .num_threads(threads_per_job)
                .thread_name(move |thread| format!("plan-{worker}-{thread}"))
                .build()
                .map_err(|error| StartError::Threads(error.to_string()))?;
            let shared = Arc::clone(&pool.shared);
            let runner = Worker::new(shared, planners, Handle::current());
            let thread = std::thread::Builder::new()
                .name(format!("worker-{worker}"))
                .spawn(move || runner.work())
                .map_err(|error| StartError::Threads(error.to_string()))?;
            pool.lock().push(thread);
        }
        Ok(pool)
    }

    /// Whether a thread has ended that was not told to.
    pub fn has_lost_workers(&self) -> bool {
        !self.shared.stopping.is_cancelled() && self.lock().iter().any(JoinHandle::is_finished)
    }

    /// Has all running jobs put back in the queue and waits for the threads to end, for `grace`
    /// at most; the jobs of those that do not end by then are put back over their heads.
    pub async fn stop(&self, grace: Duration) {
        self.tell();
        let deadline = Instant::now() + grace;
        while !self.lock().iter().all(JoinHandle::is_finished) && Instant::now() < deadline {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        for control in self.shared.running.all() {
            let job = control.lease.job;
            tracing::warn!(%job, "a run does not stop; its job is put back without it");
            let released = self
                .shared
                .store
                .release(&control.lease, control.revision());
            if let Err(error) = released.await {
                tracing::error!(%job, %error, "a job cannot be put back; the next start does it");
            }
        }
    }

    fn tell(&self) {
        // In this order: a worker enters its job first and looks at the token then.
        self.shared.stopping.cancel();
        for control in self.shared.running.all() {
            control.raise(Stop::Release);
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<JoinHandle<()>>> {
        self.threads.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.tell();
    }
}

impl Shared {
    /// Takes note of how long a job took.
    pub fn note_pace(&self, took: Duration) {
        let took = u64::try_from(took.as_micros()).unwrap_or(u64::MAX);
        // Two workers may lose each other's update: it is an estimate.
        let pace = match self.pace.load(Ordering::Relaxed) {
            0 => took,
            pace => pace - pace / 8 + took / 8,
        };
        self.pace.store(pace, Ordering::Relaxed);
    }
}
