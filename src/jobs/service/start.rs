//! Puts a service together.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use serde_json::value::{RawValue, to_raw_value};
use tokio_util::sync::CancellationToken;

use super::job_counts::JobCounts;
use super::slots::Slots;
use super::state::{Inner, Limits, Service, Shutdown};
use crate::cluster::{
    Changes, Coordinator, LeaseRenewal, Listener, LocalCoordinator, Notifier, SharedCoordinator,
    fence,
};
use crate::jobs::context::{Context, Runner};
use crate::jobs::error::StartError;
use crate::jobs::idempotency::KeysInUse;
use crate::jobs::lifecycle::Lifecycle;
use crate::jobs::memory::Memory;
use crate::jobs::mesh_cache::MeshCache;
use crate::jobs::options::{Location, Options, Role};
use crate::jobs::owner_limits::OwnerLimits;
use crate::jobs::pool::Pool;
use crate::jobs::queue::Queue;
use crate::jobs::retention;
use crate::jobs::running::Running;
use crate::jobs::webhooks::{self, Sender};
use crate::metrics::Metrics;
use crate::run;
use crate::store::postgres::{PoolSizes, Postgres};
use crate::store::sqlite::Sqlite;
use crate::store::{Audience, OpenError, SharedStore};
use crate::wire::{PlanRequest, Problem, Progress};
use graspd_core::Interrupt;
use graspd_core::mesh::Mesh;

/// How exactly the last use of a mesh is known at least; expiry mostly counts in days.
const MARK_USED_EVERY: Duration = Duration::from_secs(3600);

impl Service {
    /// Opens the store, puts the jobs that ran when the last process died back in the queue, and starts the workers.
    /// Must be called on a multi-threaded tokio runtime.
    pub async fn start(options: Options) -> Result<Self, StartError> {
        Self::start_with(options, Arc::new(plan)).await
    }

    /// Starts a service with `runner` instead of the planner.
    pub async fn start_with(options: Options, runner: Arc<Runner>) -> Result<Self, StartError> {
        let store = open(&options).await?;
        let shared = store.lease_time().map(|lease_time| {
            let coordinator = SharedCoordinator::new(Notifier::default(), fence(lease_time));
            (lease_time, Arc::new(coordinator))
        });
        let coordinator: Arc<dyn Coordinator> = match &shared {
            Some((_, coordinator)) => Arc::clone(coordinator) as _,
            None => {
                recover(&store, options.planning.max_attempts).await?;
                Arc::new(LocalCoordinator)
            }
        };
        let context = Arc::new(context(&options, &store, coordinator, runner));
        let evaluators = evaluators(&options)?;
        let webhooks = start_webhooks(&options.webhooks, &context)?;
        let planning = &options.planning;
        let (workers, threads) = (planning.workers, planning.threads_per_job);
        let pool = Pool::start(Arc::clone(&context), workers, threads)?;
        if let Some((lease_time, coordinator)) = shared {
            join_cluster(&options, &context, coordinator, lease_time);
        }
        let is_server = options.role == Role::Server;
        if is_server {
            let stopping = context.lifecycle.stopping.clone();
            tokio::spawn(retention::sweep(store.clone(), options.retention, stopping));
        }
        let service = Self(Arc::new(Inner {
            store,
            context,
            pool,
            slots: Slots::new(),
            evaluators: Arc::new(evaluators),
            followers: OwnerLimits::new(options.followers),
            keys_in_use: KeysInUse::default(),
            limits: limits(&options),
            shutdown: Shutdown {
                is_draining: AtomicBool::new(false),
                drain: options.planning.drain,
                hurry: CancellationToken::new(),
            },
            // One answer is enough: not every process that shares the store counts.
            job_counts: is_server.then(JobCounts::default),
            callback_hosts: options.webhooks.hosts,
            webhooks,
        }));
        if let Err(fault) = service.0.check_room().await {
            tracing::warn!(%fault, "no new work is accepted until there is more free space");
        }
        Ok(service)
    }
}

/// Opens the store.
async fn open(options: &Options) -> Result<SharedStore, OpenError> {
    let workers = options.planning.workers;
    Ok(match &options.store {
        Location::Folder(data) => Arc::new(Sqlite::open(data).await?),
        Location::Database(url) => {
            let sizes = match options.role {
                Role::Server => PoolSizes::of_server(workers),
                Role::Worker => PoolSizes::of_worker(workers),
            };
            Arc::new(Postgres::open(url, sizes).await?)
        }
    })
}

/// Puts the jobs that the last process left running back in the queue.
async fn recover(store: &SharedStore, max_attempts: u32) -> Result<(), StartError> {
    let exhausted = interrupted(max_attempts);
    let recovered = store.recover(max_attempts, &exhausted).await?;
    if !recovered.is_empty() {
        tracing::warn!(
            jobs = recovered.len(),
            "recovered the jobs of a process that died"
        );
    }
    Ok(())
}

fn context(
    options: &Options,
    store: &SharedStore,
    coordinator: Arc<dyn Coordinator>,
    runner: Arc<Runner>,
) -> Context {
    let changes = Arc::new(Changes::new(coordinator));
    let lifecycle = Lifecycle::default();
    let queue = Queue::new(
        store.clone(),
        Arc::clone(&changes),
        lifecycle.clone(),
        options.planning.workers,
    );
    Context {
        store: store.clone(),
        queue: Arc::new(queue),
        running: Arc::new(Running::new(Arc::clone(&changes))),
        changes,
        lifecycle,
        metrics: Metrics::new(store.metrics(), options.queue_capacity),
        memory: Memory::new(options.planning.max_memory),
        meshes: MeshCache::default(),
        limits: options.ingest,
        runner,
    }
}

/// Starts the threads that evaluate grasps: as many as plan.
fn evaluators(options: &Options) -> Result<rayon::ThreadPool, StartError> {
    let planning = &options.planning;
    let threads = planning.workers.max(1);
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.saturating_mul(planning.threads_per_job))
        .thread_name(|thread| format!("evaluate-{thread}"))
        .build()
        .map_err(|error| StartError::Threads(error.to_string()))
}

/// Starts the sender of webhooks, unless they are off.
fn start_webhooks(
    options: &webhooks::Options,
    context: &Context,
) -> Result<Option<Sender>, StartError> {
    if options.hosts.is_empty() {
        return Ok(None);
    }
    let stopping = context.lifecycle.stopping.clone();
    let sender = Sender::start(context.store.clone(), options.clone(), stopping);
    Ok(Some(sender.map_err(StartError::Tls)?))
}

/// Starts what a process does that shares its store.
fn join_cluster(
    options: &Options,
    context: &Arc<Context>,
    coordinator: Arc<SharedCoordinator>,
    lease_time: Duration,
) {
    let Context {
        store,
        changes,
        running,
        lifecycle,
        metrics,
        ..
    } = &**context;
    // Renewal and notices go on while the process ends, until its last job is put back.
    let held = Arc::clone(running);
    let renewal = LeaseRenewal {
        store: store.clone(),
        changes: Arc::clone(changes),
        held: move || held.leases(),
        lease_time,
        max_attempts: options.planning.max_attempts,
        exhausted: interrupted(options.planning.max_attempts),
        recovered: metrics.jobs.recovered.clone(),
    };
    let ended = lifecycle.ended.clone();
    tokio::spawn(async move { ended.run_until_cancelled(renewal.run()).await });
    let notifier = coordinator.notifier().clone();
    tokio::spawn(notifier.run(store.clone(), lifecycle.ended.clone()));
    let here = Arc::clone(running);
    let listener = Listener {
        store: store.clone(),
        coordinator,
        changes: Arc::clone(changes),
        lease_of: move |job| here.lease_of(job),
        stopping: lifecycle.stopping.clone(),
    };
    listener.start(Audience {
        workers: options.planning.workers > 0,
        servers: options.role == Role::Server,
    });
}

fn limits(options: &Options) -> Limits {
    let mark_used_every = options.retention.map_or(MARK_USED_EVERY, |retention| {
        (retention / 20).min(MARK_USED_EVERY)
    });
    Limits {
        workers: options.planning.workers,
        queue_capacity: options.queue_capacity,
        quota: options.quota,
        min_free_disk: options.min_free_disk,
        mark_used_every,
    }
}

/// The planner as a [`Runner`].
fn plan(
    mesh: &Mesh,
    request: &PlanRequest,
    interrupt: Interrupt<'_>,
    observe: &mut (dyn FnMut(&Progress) + Send),
) -> Result<Box<RawValue>, Problem> {
    let result = run::plan(mesh, request, interrupt, observe)?;
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
