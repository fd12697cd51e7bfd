//! The one door to meshes and jobs.

mod evaluations;
mod jobs;
mod meshes;
mod metrics;
mod pictures;
mod readiness;

use std::future::Future;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde_json::value::{RawValue, to_raw_value};
use tokio::sync::{Notify, Semaphore};
use tokio_util::sync::CancellationToken;
use tracing::Instrument;

use super::cache::MeshCache;
use super::error::{Error, StartError};
use super::pool::{Pool, Runner, Shared};
use super::running::Running;
use crate::core::mesh::Mesh;
use crate::jobs::intake::IntakeLimits;
use crate::metrics::Metrics;
use crate::run;
use crate::store::Store;
use crate::wire::{PlanRequest, Problem};

/// Uploads that are read and prepared at the same time; each may take several times the size of
/// its file in memory.
const INTAKES: usize = 2;
/// Calls for evaluations that are computed at the same time.
const EVALUATIONS: usize = 2;
/// Meshes that are drawn at the same time; each may take a hundred megabytes.
const PICTURES: usize = 2;
/// Longest that running jobs are waited for at the end.
const LAST_STEPS: Duration = Duration::from_secs(5);
/// Longest wait that a refused client is told, in seconds.
const MAX_RETRY_AFTER_S: u64 = 60;

/// What the service must be told.
#[derive(Debug, Clone)]
pub struct Options {
    /// Folder of the database and the meshes; created when missing.
    pub data_dir: PathBuf,
    /// Jobs planned at the same time.
    pub workers: usize,
    /// Threads that plan one job.
    pub threads_per_job: usize,
    /// Jobs that may wait.
    pub queue_capacity: u32,
    /// What a mesh may hold, and how long it may take to read.
    pub intake: IntakeLimits,
    /// How often a job is started at most when the server dies while it runs.
    pub max_attempts: u32,
    /// Bytes of free disk below which no new work is taken.
    pub min_free_disk: u64,
}

/// Meshes and jobs. Clones are the same service.
///
/// Ids are taken as clients write them; one that cannot be an id names nothing. What changes
/// something runs to its end even when the caller loses interest.
#[derive(Clone)]
pub struct Service(Arc<Inner>);

struct Inner {
    store: Store,
    shared: Arc<Shared>,
    pool: Pool,
    intakes: Semaphore,
    evaluations: Semaphore,
    pictures: Arc<Semaphore>,
    evaluators: Arc<rayon::ThreadPool>,
    workers: usize,
    queue_capacity: u32,
    min_free_disk: u64,
    draining: AtomicBool,
    /// When the jobs in the store were last counted.
    counted: tokio::sync::Mutex<Option<Instant>>,
}

impl Service {
    /// Opens the store, puts the jobs that ran when the last process died back in the queue, and
    /// starts the workers. Must be called on a multi-threaded tokio runtime.
    pub async fn start(options: Options) -> Result<Self, StartError> {
        Self::start_with(options, Arc::new(plan)).await
    }

    /// As [`Service::start`], with `runner` in the place of the planner.
    pub async fn start_with(options: Options, runner: Arc<Runner>) -> Result<Self, StartError> {
        let Options {
            data_dir,
            workers,
            threads_per_job,
            queue_capacity,
            intake,
            max_attempts,
            min_free_disk,
        } = options;
        let store = Store::open(&data_dir).await?;
        let recovered = store
            .recover(max_attempts, &interrupted(max_attempts))
            .await?;
        if recovered > 0 {
            tracing::warn!(jobs = recovered, "took up the jobs of a run that died");
        }
        let shared = Arc::new(Shared {
            store: store.clone(),
            metrics: Metrics::new(store.metrics(), queue_capacity),
            running: Running::default(),
            meshes: MeshCache::default(),
            limits: intake,
            runner,
            queued: Notify::new(),
            stopping: CancellationToken::new(),
            pace: AtomicU64::new(0),
        });
        let evaluators = rayon::ThreadPoolBuilder::new()
            .num_threads(workers.saturating_mul(threads_per_job))
            .thread_name(|thread| format!("evaluate-{thread}"))
            .build()
            .map_err(|error| StartError::Threads(error.to_string()))?;
        let pool = Pool::start(Arc::clone(&shared), workers, threads_per_job)?;
        let service = Self(Arc::new(Inner {
            store,
            shared,
            pool,
            intakes: Semaphore::new(INTAKES),
            evaluations: Semaphore::new(EVALUATIONS),
            pictures: Arc::new(Semaphore::new(PICTURES)),
            evaluators: Arc::new(evaluators),
            workers,
            queue_capacity,
            min_free_disk,
            draining: AtomicBool::new(false),
            counted: tokio::sync::Mutex::default(),
        }));
        if let Err(fault) = service.0.check_room().await {
            tracing::warn!(%fault, "no new work is taken until there is room");
        }
        Ok(service)
    }

    /// Takes no new work from here on. Reading, cancelling and forgetting go on.
    pub fn begin_drain(&self) {
        self.0.draining.store(true, Ordering::Relaxed);
    }

    /// Takes no new work, puts running jobs back in the queue without counting the attempt, and
    /// ends the workers; within 5 s whatever a run does. Reading, cancelling and forgetting go on.
    pub async fn shutdown(&self) {
        self.begin_drain();
        self.stop_workers(LAST_STEPS).await;
    }

    /// Closes the store, once nothing is to be answered any more. Only tidies up: what was
    /// acknowledged is safe without it.
    pub async fn close(&self) {
        self.0.store.close().await;
    }

    /// Puts running jobs back and ends the workers, waiting for `grace` at most.
    pub(super) async fn stop_workers(&self, grace: Duration) {
        self.0.pool.stop(grace).await;
    }

    /// Runs a change apart from the caller, who may be dropped at any moment when a client hangs
    /// up: no change is ever cut in half.
    async fn to_the_end<T, F>(&self, change: impl FnOnce(Arc<Inner>) -> F) -> Result<T, Error>
    where
        T: Send + 'static,
        F: Future<Output = Result<T, Error>> + Send + 'static,
    {
        // The span carries the id of the request into the log lines.
        let change = change(Arc::clone(&self.0)).in_current_span();
        match tokio::spawn(change).await {
            Ok(outcome) => outcome,
            Err(panic) => Err(Error::Bug(panic.to_string())),
        }
    }
}

impl Inner {
    fn check_open(&self) -> Result<(), Error> {
        match self.draining.load(Ordering::Relaxed) {
            true => Err(Error::Draining),
            false => Ok(()),
        }
    }
}

/// The planner as a [`Runner`].
fn plan(
    mesh: &Mesh,
    request: &PlanRequest,
    observe: &mut (dyn FnMut(&crate::wire::Progress) -> std::ops::ControlFlow<()> + Send),
) -> Result<Box<RawValue>, Problem> {
    let result = run::plan(mesh, request, observe)?;
    to_raw_value(&result).map_err(|error| {
        Problem::new(
            500,
            "internal-error",
            "Internal error",
            format!("the result cannot be written as JSON: {error}"),
        )
    })
}

fn interrupted(attempts: u32) -> Problem {
    Problem::new(
        500,
        "interrupted",
        "Interrupted too often",
        format!(
            "the server died {attempts} times while this job ran, so it is not tried again; it \
             may need more memory than there is: try a coarser mesh or a smaller population"
        ),
    )
}

fn bug(error: impl std::fmt::Display) -> Error {
    Error::Bug(error.to_string())
}
