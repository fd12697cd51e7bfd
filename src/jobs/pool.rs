//! The bounded pool: threads that take jobs off the queue and plan.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use futures_util::future::join_all;
use rayon::ThreadPoolBuilder;
use serde_json::value::RawValue;
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;

use super::ahead::Ahead;
use super::changes::Changes;
use super::control::{Control, Stop};
use super::error::StartError;
use super::ingest::IngestLimits;
use super::memory::Memory;
use super::mesh_cache::MeshCache;
use super::running::Running;
use super::watchdog;
use super::worker::Worker;
use crate::metrics::Metrics;
use crate::store::{Claim, Hold, Lease, SharedStore, StoreError};
use crate::wire::{PlanRequest, Priority, Problem, Progress};
use graspd_core::mesh::Mesh;

/// Plans a job: mesh, settings, and whom to tell about progress and to ask whether to go on.
/// Answers the result as JSON; when told to stop, with what was found so far.
pub type Runner = dyn Fn(
        &Mesh,
        &PlanRequest,
        &mut (dyn FnMut(&Progress) -> ControlFlow<()> + Send),
    ) -> Result<Box<RawValue>, Problem>
    + Send
    + Sync;

/// Of so many claims one prefers the jobs that nobody waits for.
const BATCH_EVERY: u32 = 4;

/// Time between two looks whether all runs have ended.
const DRAIN_LOOK: Duration = Duration::from_millis(20);
/// Time between two tries while the store fails.
pub const STORE_PAUSE: Duration = Duration::from_secs(1);
/// Longest that the store is waited for when jobs are put back at the end.
const LAST_RELEASES: Duration = Duration::from_secs(3);

/// What the workers share with the service.
pub struct Shared {
    pub store: SharedStore,
    pub changes: Arc<Changes>,
    pub metrics: Metrics,
    pub running: Running,
    pub ahead: Ahead,
    pub memory: Memory,
    pub meshes: MeshCache,
    pub limits: IngestLimits,
    pub runner: Arc<Runner>,
    /// A job was queued.
    pub queued: Notify,
    /// No job is begun any more.
    pub closing: CancellationToken,
    pub stopping: CancellationToken,
    /// Everything has been put back.
    pub ended: CancellationToken,
    /// How long after its last renewal a lease is not to be relied on; `None` where leases need none.
    pub fence: Option<Duration>,
    /// Claims so far, by which the classes of jobs take turns.
    pub turns: AtomicU32,
    /// Moving average of the time one job takes, in microseconds.
    pub pace: AtomicU64,
}

/// The workers and who watches them. Dropping it tells them to put their jobs back and end.
pub struct Pool(Arc<Crew>);

/// The worker threads.
pub struct Crew {
    shared: Arc<Shared>,
    threads_per_job: usize,
    runtime: Handle,
    /// One for each place that has any.
    threads: Mutex<Vec<Option<JoinHandle<()>>>>,
}

impl Pool {
    /// Starts `workers` threads, each planning on `threads_per_job` threads of its own.
    pub fn start(
        shared: Arc<Shared>,
        workers: usize,
        threads_per_job: usize,
    ) -> Result<Self, StartError> {
        let pool = Self(Arc::new(Crew {
            shared,
            threads_per_job,
            runtime: Handle::current(),
            threads: Mutex::default(),
        }));
        for place in 0..workers {
            let thread = pool.0.hire(place)?;
            pool.0.lock().push(Some(thread));
        }
        tokio::spawn(watchdog::watch(Arc::clone(&pool.0)));
        Ok(pool)
    }

    /// Whether a place has no worker: its thread has ended without being told to, or is lost in a run that
    /// does not end.
    pub fn has_lost_workers(&self) -> bool {
        let shared = &self.0.shared;
        let is_stuck = |control: &Arc<Control>| watchdog::is_stuck(control);
        !shared.stopping.is_cancelled()
            && (self.0.lock().iter().any(has_ended) || shared.running.all().iter().any(is_stuck))
    }

    /// Begins no job any more, and waits for those that run to end, for `time` at most or until `hurry`.
    pub async fn drain(&self, time: Duration, hurry: &CancellationToken) {
        let shared = &self.0.shared;
        shared.closing.cancel();
        let ended = async {
            while !shared.running.is_empty() {
                tokio::time::sleep(DRAIN_LOOK).await;
            }
        };
        let _ = hurry.run_until_cancelled(timeout(time, ended)).await;
    }

    /// Has all running jobs put back in the queue and waits for the threads to end, for `grace`
    /// at most; the jobs of those that do not end by then are put back over their heads.
    pub async fn stop(&self, grace: Duration) {
        self.tell();
        let deadline = Instant::now() + grace;
        let shared = &self.0.shared;
        while !self.0.lock().iter().all(has_ended) && Instant::now() < deadline {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        let stuck = shared.running.all();
        let releases = stuck.iter().map(|control| {
            tracing::warn!(job = %control.lease.job, "a run does not stop; its job is put back without it");
            let (revision, _) = control.close();
            shared.put_back(&control.lease, revision)
        });
        let last = async { tokio::join!(join_all(releases), shared.ahead.end()) };
        if timeout(LAST_RELEASES, last).await.is_err() {
            tracing::error!(
                "the store does not answer; others, or the next start, put the jobs back"
            );
        }
        shared.ended.cancel();
    }

    fn tell(&self) {
        self.0.shared.closing.cancel();
        // In this order: a worker enters its job first and looks at the token then.
        self.0.shared.stopping.cancel();
        for control in self.0.shared.running.all() {
            control.raise(Stop::Release);
        }
    }
}

impl Crew {
    pub fn shared(&self) -> &Arc<Shared> {
        &self.shared
    }

    /// Gives up a run that does not come back, if that may be, and starts another worker in the place of
    /// its own, whose thread ends when the run does.
    pub fn replace(&self, control: &Arc<Control>) {
        let Control { place, lease, .. } = &**control;
        if !self.shared.running.abandon(control) {
            return;
        }
        let job = lease.job;
        tracing::error!(%job, place, "a run was given up; another worker takes its place");
        let thread = self.hire(*place);
        if let Err(error) = &thread {
            tracing::error!(place, %error, "a place stays without a worker");
        }
        if let Some(taken) = self.lock().get_mut(*place) {
            *taken = thread.ok();
        }
    }

    /// Starts the worker of a place.
    fn hire(&self, place: usize) -> Result<JoinHandle<()>, StartError> {
        let threads = |error: &dyn std::fmt::Display| StartError::Threads(error.to_string());
        let planners = ThreadPoolBuilder::new()
            .num_threads(self.threads_per_job)
            .thread_name(move |thread| format!("plan-{place}-{thread}"))
            .build()
            .map_err(|error| threads(&error))?;
        let shared = Arc::clone(&self.shared);
        let worker = Worker::new(place, shared, planners, self.runtime.clone());
        std::thread::Builder::new()
            .name(format!("worker-{place}"))
            .spawn(move || worker.work())
            .map_err(|error| threads(&error))
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Option<JoinHandle<()>>>> {
        self.threads.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        self.tell();
        self.0.shared.ended.cancel();
    }
}

fn has_ended(thread: &Option<JoinHandle<()>>) -> bool {
    thread.as_ref().is_none_or(JoinHandle::is_finished)
}

impl Shared {
    /// The next job, of the class whose turn it is where one waits.
    pub async fn claim(&self) -> Result<Option<Claim>, StoreError> {
        let turn = self.turns.fetch_add(1, Ordering::Relaxed);
        let first = match turn % BATCH_EVERY {
            0 => Priority::Batch,
            _ => Priority::Interactive,
        };
        self.store.claim(first).await
    }

    /// Stops a run whose job is to stop, or is not ours any more.
    pub async fn look_at_hold(&self, control: &Control) {
        match self.store.hold(&control.lease).await {
            Ok(Hold::Held) => {}
            Ok(Hold::Cancelled) => control.raise(Stop::Cancel),
            Ok(Hold::Lost) => control.raise(Stop::Discard),
            Err(error) => tracing::warn!(%error, "cannot see whether a job was cancelled"),
        }
    }

    /// Puts a job back that no run holds, at the revision that clients have seen. Says whether the store has answered.
    pub async fn put_back(&self, lease: &Lease, revision: u64) -> bool {
        let job = lease.job;
        if let Err(error) = self.store.release(lease, revision).await {
            tracing::error!(%job, %error, "a job cannot be put back; others, or the next start, do it");
            return false;
        }
        self.tell_queued();
        self.changes.stored(job);
        true
    }

    /// Wakes a worker for jobs that were queued, here and in other processes.
    pub fn tell_queued(&self) {
        self.queued.notify_one();
        self.changes.queued();
    }

    /// Waits until a store that fails is to be tried again, or the process stops.
    pub async fn pause(&self) {
        let pause = tokio::time::sleep(STORE_PAUSE);
        let _ = self.stopping.run_until_cancelled(pause).await;
    }

    /// How long a job takes, as the last ones tell; zero when none has ended.
    pub fn pace(&self) -> Duration {
        Duration::from_micros(self.pace.load(Ordering::Relaxed))
    }

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
