//! Jobs: submitted, read, listed, cancelled, forgotten.

use std::sync::atomic::Ordering;
use std::time::Duration;

use serde_json::value::RawValue;

use super::{Inner, MAX_RETRY_AFTER_S, Service, bug};
use crate::jobs::control::Stop;
use crate::jobs::error::Error;
use crate::jobs::intake;
use crate::store::{JobFilter, NewJob, Refusal, Upload};
use crate::wire::{JobId, JobPage, JobRecord, JobState, MeshId, MeshOptions, PlanRequest};

impl Service {
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
        options: MeshOptions,
        file_name: Option<String>,
        request: PlanRequest,
    ) -> Result<JobRecord, Error> {
        self.to_the_end(move |inner| async move {
            inner.check_open()?;
            let received = upload.finish().await?;
            if let Some(known) = inner.known(&received, &options).await? {
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
            let (received, mesh) = inner.take_in(received, options, file_name).await?;
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

    /// A job as it stands, without its result.
    pub async fn job_without_result(&self, id: &str) -> Result<JobRecord, Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        self.0.job_without_result(id).await
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
        let mesh_id = mesh_id.map(str::to_owned);
        let filter = JobFilter { state, mesh_id };
        let page = self.0.store.jobs(&filter, cursor, limit).await?;
        let mut page = page.ok_or(Error::InvalidCursor)?;
        for job in &mut page.jobs {
            self.0.shared.running.refresh(job);
        }
        Ok(page)
    }

    /// Stops a job: one that waits at once, one that runs within 0.2 s, keeping what it has found if it
    /// hands that in by then. Answers the job without its result and whether there was anything left to stop.
    pub async fn cancel(&self, id: &str) -> Result<(JobRecord, bool), Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        self.to_the_end(move |inner| async move {
            let Some(mut job) = inner.store.cancel(id).await? else {
                return Ok((inner.job_without_result(id).await?, false));
            };
            // After the row, so that a worker entering the job sees one or the other.
            let running = &inner.shared.running;
            if let Some(control) = running.raise(id, Stop::Cancel) {
                control.pass(job.revision);
            }
            inner.shared.changes.stored(id);
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
            inner.shared.changes.stored(id);
            match existed {
                true => Ok(()),
                false => Err(Error::NotFound),
            }
        })
        .await
    }
}

impl Inner {
    async fn submit(&self, mesh_id: &MeshId, request: &PlanRequest) -> Result<JobRecord, Error> {
        let kept = self.store.kept(mesh_id).await?.ok_or(Error::UnknownMesh)?;
        intake::check_fit(request, kept.candidates).map_err(Error::Refused)?;
        let request = PlanRequest {
            units: request.units.or(kept.units),
            ..request.clone()
        };
        let outcome = self.store.submit(mesh_id, &self.new_job(&request)?).await?;
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
        // One place is free each time that a worker ends a job. While none has ended, or these
        // are longer ones, what runs now tells more.
        let pace = Duration::from_micros(self.shared.pace.load(Ordering::Relaxed))
            .max(self.shared.running.longest());
        let wait = pace.as_secs() / self.workers.max(1) as u64;
        Error::QueueFull {
            retry_after_s: wait.clamp(1, MAX_RETRY_AFTER_S),
        }
    }

    async fn job_without_result(&self, id: JobId) -> Result<JobRecord, Error> {
        let job = self.store.job_without_result(id).await?;
        let mut job = job.ok_or(Error::NotFound)?;
        self.shared.running.refresh(&mut job);
        Ok(job)
    }

    async fn job(&self, id: JobId) -> Result<JobRecord, Error> {
        let mut job = self.store.job(id).await?.ok_or(Error::NotFound)?;
        self.shared.running.refresh(&mut job);
        Ok(job)
    }
}
