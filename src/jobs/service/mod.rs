//! The one door to meshes and jobs.

mod batches;
mod evaluations;
mod follow;
mod jobs;
mod meshes;
mod metrics;
mod pictures;
mod readiness;

pub use jobs::MeshUpload;

use std::future::Future;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

use serde_json::value::{RawValue, to_raw_value};
use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;
use tracing::Instrument;

use self::metrics::NextCounts;
use super::ahead::Ahead;
use super::changes::Changes;
use super::error::{Error, StartError};
use super::herald::Herald;
use super::idempotency::{IdempotencyKey, InFlight};
use super::lookout;
use super::memory::Memory;
use super::mesh_cache::MeshCache;
use super::owner_limits::OwnerLimits;
use super::pool::{Pool, Runner, Shared};
use super::pulse;
use super::retention;
use super::running::Running;
use crate::jobs::ingest::IngestLimits;
use crate::jobs::webhooks::{self, AllowedHosts, Sender};
use crate::metrics::Metrics;
use crate::run;
use crate::store::postgres::{Postgres, Sizes};
use crate::store::sqlite::Sqlite;
use crate::store::{Audience, OpenError, Owner, SharedStore};
use crate::wire::{PlanRequest, Problem};
use graspd_core::mesh::Mesh;

pub use follow::Follower;

/// Uploads that are read and prepared at the same time; each may take several times the size of
/// its file in memory.
const INTAKES: usize = 2;
/// Uploads that have come in and wait to be read, each with its file on the disk.
const LINE: usize = 256;
/// Calls for evaluations that are computed at the same time.
const EVALUATIONS: usize = 2;
/// Meshes that are drawn at the same time; each may take a hundred megabytes.
const PICTURES: usize = 2;
/// Large ones of them that wait for their turn, the one that is drawn included.
const HEAVY_LINE: usize = 16;
/// How exactly the last use of a mesh is known at least; expiry mostly counts in days.
const MAX_TOUCH: Duration = Duration::from_secs(3600);
/// Longest that running jobs are waited for at the end.
const LAST_STEPS: Duration = Duration::from_secs(5);
/// Longest wait that a refused client is told, in seconds.
const MAX_RETRY_AFTER_S: u64 = 60;

/// What the service must be told.
#[derive(Debug, Clone)]
pub struct Options {
    /// Where everything is kept.
    pub store: Location,
    /// What this process is for.
    pub role: Role,
    /// Jobs planned at the same time.
    pub workers: usize,
    /// Threads that plan one job.
    pub threads_per_job: usize,
    /// Jobs that may wait.
    pub queue_capacity: u32,
    /// What each owner may have of it.
    pub quota: Quota,
    /// How long ended jobs and unused meshes are kept; `None` is for ever.
    pub retention: Option<Duration>,
    /// What a mesh may hold, and how long it may take to read.
    pub ingest: IngestLimits,
    /// How often a job is started at most when the server dies while it runs.
    pub max_attempts: u32,
    /// Clients that may follow jobs at the same time.
    pub followers: usize,
    /// Bytes of memory that the process may take before a run is stopped; as many as it likes if `None`.
    pub max_memory: Option<u64>,
    /// Bytes of free disk below which no new work is taken.
    pub min_free_disk: u64,
    /// Who may be told of the end of a job.
    pub webhooks: webhooks::Options,
    /// How long running jobs may go on when the process is to end, before they are put back.
    pub drain: Duration,
}

/// Where a store is.
#[derive(Debug, Clone)]
pub enum Location {
    /// A folder with a database and the meshes, for this process alone; created when missing.
    Folder(PathBuf),
    /// The address of a PostgreSQL database, `postgres://...`, that others may share.
    Database(String),
}

/// What a process is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Serves clients, and plans with the workers that it has.
    Server,
    /// Only plans.
    Worker,
}

/// What one owner may have; whoever sends without a key has no bounds of their own.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quota {
    /// Most jobs that wait.
    pub queued: Option<u32>,
    /// Most bytes of mesh files.
    pub mesh_bytes: Option<u64>,
}

impl Quota {
    fn of(self, owner: &Owner) -> Self {
        match owner.is_anonymous() {
            true => Self::default(),
            false => self,
        }
    }
}

/// Meshes and jobs. Clones are the same service.
///
/// Ids are taken as clients write them; one that cannot be an id names nothing. What changes
/// something runs to its end even when the caller loses interest.
#[derive(Clone)]
pub struct Service(Arc<Inner>);

struct Inner {
    store: SharedStore,
    shared: Arc<Shared>,
    pool: Pool,
    line: Arc<Semaphore>,
    intakes: Arc<Semaphore>,
    evaluations: Arc<Semaphore>,
    pictures: Arc<Semaphore>,
    heavy: Arc<Semaphore>,
    heavy_line: Arc<Semaphore>,
    evaluators: Arc<rayon::ThreadPool>,
    followers: OwnerLimits,
    role: Role,
    workers: usize,
    queue_capacity: u32,
    quota: Quota,
    /// How exactly the last use of a mesh has to be known.
    touch_every: Duration,
    in_flight: InFlight,
    min_free_disk: u64,
    draining: AtomicBool,
    /// How long running jobs may go on when the process is to end.
    drain: Duration,
    /// Raised when that is to be cut short.
    hurry: CancellationToken,
    next_counts: tokio::sync::Mutex<NextCounts>,
    callback_hosts: AllowedHosts,
    /// None while webhooks are off.
    webhooks: Option<Sender>,
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
            store,
            role,
            workers,
            threads_per_job,
            queue_capacity,
            quota,
            retention,
            ingest,
            max_attempts,
            followers,
            max_memory,
            min_free_disk,
            webhooks,
            drain,
        } = options;
        let store = store.open(role, workers).await?;
        let exhausted = interrupted(max_attempts);
        let lease_time = store.lease_time();
        let herald = lease_time.map(|_| Herald::default());
        if lease_time.is_none() {
            let recovered = store.recover(max_attempts, &exhausted).await?;
            if !recovered.is_empty() {
                tracing::warn!(
                    jobs = recovered.len(),
                    "took up the jobs of a run that died"
                );
            }
        }
        let changes = Arc::new(herald.clone().map(Changes::shared).unwrap_or_default());
        let shared = Arc::new(Shared {
            store: store.clone(),
            metrics: Metrics::new(store.metrics(), queue_capacity),
            running: Running::new(Arc::clone(&changes)),
            changes,
            memory: Memory::new(max_memory),
            meshes: MeshCache::default(),
            limits: ingest,
            runner,
            queued: Notify::new(),
            closing: CancellationToken::new(),
            stopping: CancellationToken::new(),
            ended: CancellationToken::new(),
            fence: lease_time.map(pulse::fence),
            turns: AtomicU32::new(0),
            pace: AtomicU64::new(0),
            ahead: Ahead::new(workers),
        });
        let evaluators = rayon::ThreadPoolBuilder::new()
            .num_threads(workers.max(1).saturating_mul(threads_per_job))
            .thread_name(|thread| format!("evaluate-{thread}"))
            .build()
            .map_err(|error| StartError::Threads(error.to_string()))?;
        let callback_hosts = webhooks.hosts.clone();
        let webhooks = match callback_hosts.is_empty() {
            true => None,
            false => {
                let stopping = shared.stopping.clone();
                Some(Sender::start(store.clone(), webhooks, stopping).map_err(StartError::Tls)?)
            }
        };
        let pool = Pool::start(Arc::clone(&shared), workers, threads_per_job)?;
        if let Some(lease_time) = lease_time {
            let beat = pulse::beat(Arc::clone(&shared), lease_time, max_attempts, exhausted);
            tokio::spawn(beat);
        }
        if let Some(herald) = herald {
            let audience = Audience {
                workers: workers > 0,
                servers: role == Role::Server,
            };
            // Until the last job is put back, of which others are to know.
            let ended = shared.ended.clone();
            tokio::spawn(herald.clone().work(store.clone(), ended));
            tokio::spawn(lookout::listen(Arc::clone(&shared), herald, audience));
            tokio::spawn(lookout::look(Arc::clone(&shared)));
        }
        if role == Role::Server {
            tokio::spawn(retention::sweep(Arc::clone(&shared), retention));
        }
        let service = Self(Arc::new(Inner {
            store,
            shared,
            pool,
            line: Arc::new(Semaphore::new(LINE)),
            intakes: Arc::new(Semaphore::new(INTAKES)),
            evaluations: Arc::new(Semaphore::new(EVALUATIONS)),
            pictures: Arc::new(Semaphore::new(PICTURES)),
            heavy: Arc::new(Semaphore::new(1)),
            heavy_line: Arc::new(Semaphore::new(HEAVY_LINE)),
            evaluators: Arc::new(evaluators),
            followers: OwnerLimits::new(followers),
            role,
            workers,
            queue_capacity,
            quota,
            touch_every: retention.map_or(MAX_TOUCH, |retention| (retention / 20).min(MAX_TOUCH)),
            in_flight: InFlight::default(),
            min_free_disk,
            draining: AtomicBool::new(false),
            drain,
            hurry: CancellationToken::new(),
            next_counts: tokio::sync::Mutex::default(),
            callback_hosts,
            webhooks,
        }));
        if let Err(fault) = service.0.check_room().await {
            tracing::warn!(%fault, "no new work is taken until there is room");
        }
        Ok(service)
    }

    /// The owner that an API key stands for, if it is good.
    pub async fn owner_of(&self, key: &str) -> Result<Option<Owner>, Error> {
        Ok(self.0.store.owner_of(key).await?)
    }

    /// Whether any API key is good.
    pub async fn has_keys(&self) -> Result<bool, Error> {
        Ok(self.0.store.has_keys().await?)
    }

    /// Begins a submission under a key of its sender's choice, of 1 to 255 characters. Refused while
    /// another one under the same key is under way.
    pub fn begin_submission(&self, owner: &Owner, key: &str) -> Result<IdempotencyKey, Error> {
        self.0.in_flight.begin(owner, key)
    }

    /// Takes no new work from here on. Reading, cancelling and forgetting go on.
    pub fn begin_drain(&self) {
        self.0.draining.store(true, Ordering::Relaxed);
    }

    /// Takes no new work, lets running jobs go on for as long as they may, puts the rest back in the queue without
    /// counting the attempt, and ends the workers; within 5 s beyond that whatever a run does. Webhooks under way
    /// have 3 s, the rest waits for the next start. Reading, cancelling and forgetting go on.
    pub async fn shutdown(&self) {
        self.begin_drain();
        self.0.pool.drain(self.0.drain, &self.0.hurry).await;
        self.stop_workers(LAST_STEPS).await;
        if let Some(webhooks) = &self.0.webhooks {
            webhooks.ended().await;
        }
    }

    /// Cuts short the time that running jobs are given when the process ends.
    pub fn hurry(&self) {
        self.0.hurry.cancel();
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
    async fn run_detached<T, F>(&self, change: impl FnOnce(Arc<Inner>) -> F) -> Result<T, Error>
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

impl Location {
    async fn open(&self, role: Role, workers: usize) -> Result<SharedStore, OpenError> {
        Ok(match self {
            Self::Folder(data) => Arc::new(Sqlite::open(data).await?),
            Self::Database(url) => {
                let sizes = match role {
                    Role::Server => Sizes::of_server(workers),
                    Role::Worker => Sizes::of_worker(workers),
                };
                Arc::new(Postgres::open(url, sizes).await?)
            }
        })
    }
}

impl Inner {
    fn check_open(&self) -> Result<(), Error> {
        match self.draining.load(Ordering::Relaxed) {
            true => Err(Error::Draining),
            false => Ok(()),
        }
    }

    /// A place among those whose mesh has come in, to be kept until it is dealt with: the work goes on when
    /// its sender hangs up, and must not pile up.
    fn wait_in_line(&self) -> Result<OwnedSemaphorePermit, Error> {
        Arc::clone(&self.line)
            .try_acquire_owned()
            .map_err(|_| Error::Unready {
                kind: "busy",
                detail: "as many meshes wait to be read as may; send it again in a moment",
            })
    }

    /// Leave to read and prepare a mesh, to be kept until that is done even when nobody waits for it any more.
    async fn intake(&self) -> Result<OwnedSemaphorePermit, Error> {
        let intakes = Arc::clone(&self.intakes);
        intakes.acquire_owned().await.map_err(bug)
    }

    fn check_memory(&self) -> Result<(), Error> {
        match self.shared.memory.is_over() {
            true => Err(Error::OutOfMemory),
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
