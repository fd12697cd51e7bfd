//! The one door to meshes and jobs.

use std::future::Future;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use serde_json::value::{RawValue, to_raw_value};
use tokio::sync::{Notify, Semaphore};
use tokio_util::sync::CancellationToken;
use tracing::Instrument;

use super::cache::MeshCache;
use super::error::{Error, StartError};
use super::intake;
use super::pool::{Pool, Runner, Shared};
use super::running::{Running, Stop};
use crate::core::mesh::{Format, Limits, Mesh};
use crate::run;
use crate::store::{
    Deletion, Ending, JobFilter, NewJob, NewMesh, Received, Refusal, Store, StoreError, Upload,
};
use crate::wire::{
    JobId, JobPage, JobRecord, JobState, MeshFormat, MeshId, MeshPage, MeshRecord, MeshReport,
    PlanRequest, Problem,
};

/// Uploads that are read and prepared at the same time; each may take several times the size of
/// its file in memory.
const INTAKES: usize = 2;
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
    /// What a mesh may hold.
    pub mesh_limits: Limits,
    /// How often a job is started at most when the server dies while it runs.
    pub max_attempts: u32,
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
    workers: usize,
    queue_capacity: u32,
    draining: AtomicBool,
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
            mesh_limits,
            max_attempts,
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
            running: Running::default(),
            meshes: MeshCache::default(),
            limits: mesh_limits,
            runner,
            queued: Notify::new(),
            stopping: CancellationToken::new(),
            pace: AtomicU64::new(0),
        });
        let pool = Pool::start(Arc::clone(&shared), workers, threads_per_job)?;
        Ok(Self(Arc::new(Inner {
            store,
            shared,
            pool,
            intakes: Semaphore::new(INTAKES),
            workers,
            queue_capacity,
            draining: AtomicBool::new(false),
        })))
    }

    /// A file on disk to receive a mesh into; it is removed unless it becomes one.
    pub async fn begin_upload(&self) -> Result<Upload, Error> {
        self.0.check_open()?;
        Ok(self.0.store.begin_upload().await?)
    }

    /// Reads, checks and keeps a mesh; it is on stable storage once this returns. Says whether
    /// it is new: the same bytes in the same format are the same mesh, under its first name.
    ///
    /// `format` is what the sender says, else the content tells. Of a mesh that cannot be used
    /// nothing stays.
    pub async fn add_mesh(
        &self,
        upload: Upload,
        format: Option<Format>,
        file_name: Option<String>,
    ) -> Result<(MeshRecord, bool), Error> {
        self.to_the_end(move |inner| async move {
            inner.check_open()?;
            let received = upload.finish().await?;
            if let Some(known) = inner.known(&received, format).await? {
                return Ok((known, false));
            }
            let (received, mesh) = inner.take_in(received, format, file_name).await?;
            Ok(inner.store.add_mesh(received, &mesh).await?)
        })
        .await
    }

    /// The record of a mesh.
    pub async fn mesh(&self, id: &str) -> Result<MeshRecord, Error> {
        let id = MeshId::parse(id).ok_or(Error::NotFound)?;
        self.0.store.mesh(&id).await?.ok_or(Error::NotFound)
    }

    /// At most `limit` meshes (1 to [`crate::store::MAX_PAGE`]), newest first, from where the
    /// page that answered `cursor` ended.
    pub async fn meshes(&self, limit: u32, cursor: Option<&str>) -> Result<MeshPage, Error> {
        let page = self.0.store.meshes(cursor, limit).await?;
        page.ok_or(Error::InvalidCursor)
    }

    /// Forgets a mesh unless a queued or running job needs it.
    pub async fn delete_mesh(&self, id: &str) -> Result<(), Error> {
        let id = MeshId::parse(id).ok_or(Error::NotFound)?;
        self.to_the_end(move |inner| async move {
            let deletion = inner.store.delete_mesh(&id).await?;
            match deletion {
                Deletion::Done => {
                    inner.shared.meshes.forget(&id);
                    Ok(())
                }
                Deletion::NotFound => Err(Error::NotFound),
                Deletion::InUse => Err(Error::MeshInUse),
            }
        })
        .await
    }

    /// Queues a job on a mesh that is here; it is on stable storage once this returns it.
    pub async fn submit(&self, mesh_id: &str, request: PlanRequest) -> Result<JobRecord, Error> {
        let mesh_id = MeshId::parse(mesh_id).ok_or(Error::UnknownMesh)?;
        self.to_the_end(move |inner| async move {
            inner.check_open()?;
            inner.submit(&mesh_id, &request).await
        })
        .await
    }

    /// Keeps a mesh, as [`Service::add_mesh`], and queues a job on it: both or, when either is
    /// refused, neither.
    pub async fn submit_with_upload(
        &self,
        upload: Upload,
        format: Option<Format>,
        file_name: Option<String>,
        request: PlanRequest,
    ) -> Result<JobRecord, Error> {
        self.to_the_end(move |inner| async move {
            inner.check_open()?;
            let received = upload.finish().await?;
            if let Some(known) = inner.known(&received, format).await? {
                match inner.submit(&known.id, &request).await {
                    // Deleted just now: take the upload in its place.
                    Err(Error::UnknownMesh) => {}
                    outcome => return outcome,
                }
            }
            // The queue decides in the store; this only spares the work of a hopeless intake.
            if inner.store.queued().await? >= inner.queue_capacity {
                return Err(inner.queue_full());
            }
            let (received, mesh) = inner.take_in(received, format, file_name).await?;
            let candidates = mesh.report.candidates as u64;
            intake::check_fit(&request, candidates).map_err(Error::Refused)?;
            let job = inner.new_job(&request)?;
            let outcome = inner.store.add_mesh_and_job(received, &mesh, &job).await?;
            inner.queued(outcome)
        })
        .await
    }

    /// A job as it stands, with its result if there is one.
    pub async fn job(&self, id: &str) -> Result<JobRecord, Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        self.0.job(id).await
    }

    /// The result of a job alone, to the byte as the planner wrote it; `None` while there is none.
    pub async fn result(&self, id: &str) -> Result<Option<Box<RawValue>>, Error> {
        Ok(self.job(id).await?.result)
    }

    /// At most `limit` jobs (1 to [`crate::store::MAX_PAGE`]) without their results, newest
    /// first, from where the page that answered `cursor` ended; only those in `state` and on
    /// `mesh_id`, where given.
    pub async fn jobs(
        &self,
        state: Option<JobState>,
        mesh_id: Option<&str>,
        limit: u32,
        cursor: Option<&str>,
    ) -> Result<JobPage, Error> {
        let mesh_id = match mesh_id.map(MeshId::parse) {
            // What cannot be an id is on no job.
            Some(None) => {
                return Ok(JobPage {
                    jobs: Vec::new(),
                    next_cursor: None,
                });
            }
            Some(Some(id)) => Some(id),
            None => None,
        };
        let filter = JobFilter { state, mesh_id };
        let page = self.0.store.jobs(&filter, cursor, limit).await?;
        let mut page = page.ok_or(Error::InvalidCursor)?;
        for job in &mut page.jobs {
            self.0.shared.running.refresh(job);
        }
        Ok(page)
    }

    /// Stops a job: one that waits at once, one that runs within moments, keeping what it has
    /// found. Answers the job and whether there was anything left to stop.
    pub async fn cancel(&self, id: &str) -> Result<(JobRecord, bool), Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        self.to_the_end(move |inner| async move {
            let Some(mut job) = inner.store.cancel(id).await? else {
                return Ok((inner.job(id).await?, false));
            };
            // After the row, so that a worker entering the job sees one or the other.
            let running = &inner.shared.running;
            if let Some(control) = running.raise(id, Stop::Cancel)
                && control.is_preparing()
            {
                // Preparing a mesh cannot be interrupted and may take seconds: end the job here,
                // the worker finds its lease void.
                inner
                    .store
                    .finish(&control.lease, &Ending::Nothing, &control.progress(), 0)
                    .await?;
                return Ok((inner.job(id).await?, true));
            }
            running.refresh(&mut job);
            Ok((job, true))
        })
        .await
    }

    /// Cancels and forgets a job.
    pub async fn delete_job(&self, id: &str) -> Result<(), Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        self.to_the_end(move |inner| async move {
            let existed = inner.store.delete_job(id).await?;
            inner.shared.running.raise(id, Stop::Discard);
            match existed {
                true => Ok(()),
                false => Err(Error::NotFound),
            }
        })
        .await
    }

    /// Whether new work is taken: fails as submitting would.
    pub async fn ready(&self) -> Result<(), Error> {
        self.0.check_open()?;
        Ok(self.0.store.ping().await?)
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

    /// The mesh that these bytes already are.
    async fn known(
        &self,
        received: &Received,
        format: Option<Format>,
    ) -> Result<Option<MeshRecord>, StoreError> {
        let format = format.map(MeshFormat::from);
        for candidate in MeshFormat::ALL {
            if format.is_none_or(|format| format == candidate)
                && let Some(mesh) = self.store.mesh(&received.mesh_id(candidate)).await?
            {
                return Ok(Some(mesh));
            }
        }
        Ok(None)
    }

    /// Reads and prepares a received mesh, a few at a time.
    async fn take_in(
        &self,
        received: Received,
        format: Option<Format>,
        file_name: Option<String>,
    ) -> Result<(Received, NewMesh), Error> {
        let _permit = self.intakes.acquire().await.map_err(bug)?;
        let limits = self.shared.limits;
        let work = move || -> Result<_, Error> {
            let bytes = std::fs::read(&received.path).map_err(StoreError::from)?;
            let prepared = intake::prepare(&bytes, format, &limits);
            Ok((received, prepared.map_err(Error::Refused)?))
        };
        let (received, (format, mesh)) = tokio::task::spawn_blocking(work).await.map_err(bug)??;
        let format = MeshFormat::from(format);
        let report = MeshReport::from(mesh.report());
        let id = received.mesh_id(format);
        self.shared.meshes.put(id, Arc::new(mesh));
        let mesh = NewMesh {
            format,
            file_name,
            report,
        };
        Ok((received, mesh))
    }

    async fn submit(&self, mesh_id: &MeshId, request: &PlanRequest) -> Result<JobRecord, Error> {
        let candidates = self.store.candidates(mesh_id).await?;
        intake::check_fit(request, candidates.ok_or(Error::UnknownMesh)?)
            .map_err(Error::Refused)?;
        let outcome = self.store.submit(mesh_id, &self.new_job(request)?).await?;
        self.queued(outcome)
    }

    fn new_job(&self, request: &PlanRequest) -> Result<NewJob, Error> {
        Ok(NewJob {
            request: serde_json::to_string(request).map_err(bug)?,
            label: request.label.clone(),
            capacity: self.queue_capacity,
        })
    }

    fn queued(&self, outcome: Result<JobRecord, Refusal>) -> Result<JobRecord, Error> {
        match outcome {
            Ok(job) => {
                self.shared.queued.notify_one();
                Ok(job)
            }
            Err(Refusal::UnknownMesh) => Err(Error::UnknownMesh),
            Err(Refusal::QueueFull) => Err(self.queue_full()),
        }
    }

    fn queue_full(&self) -> Error {
        // One place is free each time that a worker ends a job.
        let pace = Duration::from_micros(self.shared.pace.load(Ordering::Relaxed));
        let wait = pace.as_secs() / self.workers.max(1) as u64;
        Error::QueueFull {
            retry_after_s: wait.clamp(1, MAX_RETRY_AFTER_S),
        }
    }

    async fn job(&self, id: JobId) -> Result<JobRecord, Error> {
        let mut job = self.store.job(id).await?.ok_or(Error::NotFound)?;
        self.shared.running.refresh(&mut job);
        Ok(job)
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
