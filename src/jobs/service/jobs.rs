//! Jobs: submitted, read, listed, cancelled, deleted.

use std::sync::Arc;

use serde_json::value::RawValue;

use super::meshes::MeshUpload;
use super::state::{Inner, Service};
use crate::cluster::StopReason;
use crate::jobs::context::Context;
use crate::jobs::control::Control;
use crate::jobs::error::Error;
use crate::jobs::idempotency::IdempotencyKey;
use crate::jobs::ingest;
use crate::store::{Earlier, JobFilter, NewJob, Owner, Refusal, Submission};
use crate::wire::{FieldError, JobId, JobPage, JobRecord, MeshId, PlanRequest, Problem};

/// Longest that a refused client is asked to wait, in seconds.
const MAX_RETRY_AFTER_S: u64 = 60;

impl Service {
    /// Queues a job on a mesh in the store; it is on stable storage once this returns it. A repeated submission returns
    /// the job that the first one made.
    pub async fn submit(
        &self,
        owner: &Owner,
        mesh_id: &str,
        request: PlanRequest,
        key: Option<IdempotencyKey>,
    ) -> Result<JobRecord, Error> {
        let mesh_id = MeshId::parse(mesh_id).ok_or(Error::UnknownMesh)?;
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let submission = key.as_ref().map(|key| key.mesh_submission(&mesh_id));
            if let Some(job) = inner.earlier(&owner, submission.as_ref()).await? {
                return Ok(job);
            }
            inner.check_open()?;
            inner.check_room().await?;
            let request = inner.with_callback(request)?;
            inner.submit(&owner, &mesh_id, &request, submission).await
        })
        .await
    }

    /// Adds a mesh, as [`Service::add_mesh`] does, and queues a job on it: both or, when either is refused, neither. A
    /// repeated submission returns the job that the first one made.
    pub async fn submit_with_upload(
        &self,
        owner: &Owner,
        MeshUpload {
            upload,
            options,
            file_name,
        }: MeshUpload,
        request: PlanRequest,
        key: Option<IdempotencyKey>,
    ) -> Result<JobRecord, Error> {
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let _place = inner.slots.upload()?;
            let received = upload.finish().await?;
            let submission = key
                .as_ref()
                .map(|key| key.upload_submission(&received, &options));
            if let Some(job) = inner.earlier(&owner, submission.as_ref()).await? {
                return Ok(job);
            }
            inner.check_open()?;
            let request = inner.with_callback(request)?;
            if let Some(known) = inner.find_by_content(&owner, &received, &options).await? {
                let submission = submission.clone();
                match inner.submit(&owner, &known.id, &request, submission).await {
                    // Deleted just now: use the upload instead.
                    Err(Error::UnknownMesh) => {}
                    outcome => return outcome,
                }
            }
            // The store decides in the end; this only spares the work of reading a mesh for nothing.
            if inner.store.queued().await? >= inner.limits.queue_capacity {
                return Err(inner.refused(&owner, Refusal::QueueFull));
            }
            let (received, mesh) = inner
                .ingest_mesh(&owner, received, options, file_name)
                .await?;
            let candidates = mesh.report.candidates as u64;
            ingest::check_fit(&request, candidates).map_err(Error::Refused)?;
            let job = inner.new_job(&owner, &request, submission)?;
            let outcome = inner.store.add_mesh_and_job(received, &mesh, &job).await?;
            inner.queued(&owner, outcome)
        })
        .await
    }

    /// Returns a job as it is now, with its result if there is one.
    pub async fn job(&self, owner: &Owner, id: &str) -> Result<JobRecord, Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        self.0.job(owner, id).await
    }

    /// Returns a job as it is now, without its result.
    pub async fn job_without_result(&self, owner: &Owner, id: &str) -> Result<JobRecord, Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        self.0.job_without_result(owner, id).await
    }

    /// Returns the result of a job, to the byte as the planner wrote it; `None` while there is none.
    pub async fn result(&self, owner: &Owner, id: &str) -> Result<Option<Box<RawValue>>, Error> {
        Ok(self.job(owner, id).await?.result)
    }

    /// Returns at most `limit` jobs (1 to [`crate::store::MAX_PAGE`]) that match `filter`, without their results, newest
    /// first, from where the page that returned `cursor` ended.
    pub async fn jobs(
        &self,
        filter: &JobFilter,
        limit: u32,
        cursor: Option<&str>,
    ) -> Result<JobPage, Error> {
        let page = self.0.store.jobs(filter, cursor, limit).await?;
        let mut page = page.ok_or(Error::InvalidCursor)?;
        for job in &mut page.jobs {
            self.0.context.running.refresh(job);
        }
        Ok(page)
    }

    /// Cancels a job: one that waits at once, one that runs within 0.2 s; what its run has found is kept if it hands that
    /// in by then. Returns the job without its result and whether there was anything left to cancel.
    pub async fn cancel(&self, owner: &Owner, id: &str) -> Result<(JobRecord, bool), Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let store = &inner.store;
            let Some(mut job) = store.cancel(&owner, id).await? else {
                return Ok((inner.job_without_result(&owner, id).await?, false));
            };
            if let Some(control) = inner.stop_run(id, StopReason::Cancel) {
                control.held.skip_to(job.revision);
            }
            inner.context.running.refresh(&mut job);
            Ok((job, true))
        })
        .await
    }

    /// Cancels and deletes a job.
    pub async fn delete_job(&self, owner: &Owner, id: &str) -> Result<(), Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let store = &inner.store;
            if !store.delete_job(&owner, id).await? {
                return Err(inner.absent(&owner, id).await);
            }
            inner.stop_run(id, StopReason::Discard);
            Ok(())
        })
        .await
    }
}

impl Inner {
    /// Stops the run of a job that was cancelled or deleted, if it is here, and announces that to those who follow it.
    ///
    /// Call it after the record in the store has changed: a worker that enters the job meanwhile looks there.
    pub(super) fn stop_run(&self, job: JobId, reason: StopReason) -> Option<Arc<Control>> {
        let Context {
            running, changes, ..
        } = &*self.context;
        // In this order: a worker enters its run first, and then asks whether the job may have been stopped.
        changes.coordinator().remember_stop(job);
        let control = running.get(job);
        if let Some(control) = &control {
            control.request_stop(reason);
        }
        changes.announce_stop(job);
        control
    }

    /// Returns the job that a submission made when it was sent before.
    async fn earlier(
        &self,
        owner: &Owner,
        submission: Option<&Submission>,
    ) -> Result<Option<JobRecord>, Error> {
        let Some(submission) = submission else {
            return Ok(None);
        };
        match self.store.earlier(owner, submission).await? {
            None => Ok(None),
            Some(Earlier::Other) => Err(Error::KeyReused),
            Some(Earlier::Same(id)) => match self.job_without_result(owner, id).await {
                Err(Error::NotFound) => Err(Error::Gone),
                job => job.map(Some),
            },
        }
    }

    async fn submit(
        &self,
        owner: &Owner,
        mesh_id: &MeshId,
        request: &PlanRequest,
        submission: Option<Submission>,
    ) -> Result<JobRecord, Error> {
        let kept = self.store.kept(owner, mesh_id).await?;
        let kept = kept.ok_or(Error::UnknownMesh)?;
        ingest::check_fit(request, kept.candidates).map_err(Error::Refused)?;
        let request = PlanRequest {
            units: request.units.or(kept.units),
            ..request.clone()
        };
        let job = self.new_job(owner, &request, submission)?;
        let outcome = self.store.submit(mesh_id, &job).await?;
        self.queued(owner, outcome)
    }

    /// Returns the request with its callback URL in normal form, if the server may call it.
    pub(super) fn with_callback(&self, mut request: PlanRequest) -> Result<PlanRequest, Error> {
        if let Some(url) = &request.callback_url {
            let url = self.callback_hosts.check(url).map_err(|detail| {
                let pointer = "/callback_url".to_owned();
                Error::Refused(Problem::invalid(vec![FieldError { pointer, detail }]))
            })?;
            request.callback_url = Some(url.into());
        }
        Ok(request)
    }

    fn new_job(
        &self,
        owner: &Owner,
        request: &PlanRequest,
        submission: Option<Submission>,
    ) -> Result<NewJob, Error> {
        Ok(NewJob {
            owner: owner.clone(),
            request: serde_json::to_string(request).map_err(Error::bug)?,
            label: request.label.clone(),
            priority: request.priority,
            capacity: self.limits.queue_capacity,
            share: self.quota(owner).queued,
            submission,
        })
    }

    fn queued(
        &self,
        owner: &Owner,
        outcome: Result<JobRecord, Refusal>,
    ) -> Result<JobRecord, Error> {
        if let Ok(job) = &outcome {
            self.context.changes.announce_queued();
            self.context.metrics.jobs.submitted.inc();
            tracing::info!(job = %job.id, mesh = job.mesh_id, "job queued");
        }
        outcome.map_err(|refusal| self.refused(owner, refusal))
    }

    /// Returns what a refusal of the store means to an owner.
    pub(super) fn refused(&self, owner: &Owner, refusal: Refusal) -> Error {
        let quota = self.quota(owner);
        match refusal {
            Refusal::UnknownMesh => Error::UnknownMesh,
            Refusal::Submitted => Error::InFlight,
            Refusal::QueueFull => Error::QueueFull {
                retry_after_s: self.retry_after_s(),
            },
            Refusal::ShareUsed => Error::QueueQuotaUsed {
                share: quota.queued.unwrap_or_default(),
                retry_after_s: self.retry_after_s(),
            },
            Refusal::RoomUsed => Error::MeshQuotaUsed {
                room: quota.mesh_bytes.unwrap_or_default(),
            },
        }
    }

    /// Returns the seconds until a place in the queue is likely to be free.
    fn retry_after_s(&self) -> u64 {
        // A place becomes free each time that a worker ends a job. While none has ended, or the running jobs are longer
        // than the last ones, their age says more.
        let Context { queue, running, .. } = &*self.context;
        let pace = queue.pace().max(running.longest());
        let wait = pace.as_secs() / self.limits.workers.max(1) as u64;
        wait.clamp(1, MAX_RETRY_AFTER_S)
    }

    pub(super) async fn job_without_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<JobRecord, Error> {
        match self.store.job_without_result(owner, id).await? {
            Some(job) => self.up_to_date(job).await,
            None => Err(self.absent(owner, id).await),
        }
    }

    async fn job(&self, owner: &Owner, id: JobId) -> Result<JobRecord, Error> {
        match self.store.job(owner, id).await? {
            Some(job) => self.up_to_date(job).await,
            None => Err(self.absent(owner, id).await),
        }
    }

    /// Returns a stored job with the progress of its run and what is known of its callback.
    async fn up_to_date(&self, mut job: JobRecord) -> Result<JobRecord, Error> {
        self.context.running.refresh(&mut job);
        if job.request.get().contains("\"callback_url\"") {
            job.callback = self.store.callback(job.id).await?;
        }
        Ok(job)
    }

    /// Returns why a job does not exist.
    async fn absent(&self, owner: &Owner, id: JobId) -> Error {
        match self.store.has_expired(owner, id).await {
            Ok(true) => Error::Gone,
            Ok(false) => Error::NotFound,
            Err(error) => error.into(),
        }
    }
}
