//! Jobs: submitted, read, listed, cancelled, forgotten.

use std::sync::Arc;

use serde_json::value::RawValue;

use super::{Inner, MAX_RETRY_AFTER_S, Service, bug};
use crate::jobs::control::{Control, Stop};
use crate::jobs::error::Error;
use crate::jobs::idempotency::IdempotencyKey;
use crate::jobs::ingest;
use crate::jobs::pool::Shared;
use crate::store::{Earlier, JobFilter, NewJob, Owner, Refusal, Submission, Upload};
use crate::wire::{
    FieldError, JobId, JobPage, JobRecord, MeshId, MeshOptions, PlanRequest, Problem,
};

/// A mesh file that has come in, and what its sender said of it.
pub struct MeshUpload {
    pub upload: Upload,
    pub options: MeshOptions,
    pub file_name: Option<String>,
}

impl Service {
    /// Queues a job on a mesh that is here; it is on stable storage once this returns it. A submission that
    /// was made before answers the job that it made then.
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

    /// Keeps a mesh, as [`Service::add_mesh`], and queues a job on it: both or, when either is
    /// refused, neither. A submission that was made before answers the job that it made then.
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
            let _place = inner.wait_in_line()?;
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
                    // Deleted just now: take the upload in its place.
                    Err(Error::UnknownMesh) => {}
                    outcome => return outcome,
                }
            }
            // The queue decides in the store; this only spares the work of a hopeless intake.
            if inner.store.queued().await? >= inner.queue_capacity {
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

    /// A job as it stands, with its result if there is one.
    pub async fn job(&self, owner: &Owner, id: &str) -> Result<JobRecord, Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        self.0.job(owner, id).await
    }

    /// A job as it stands, without its result.
    pub async fn job_without_result(&self, owner: &Owner, id: &str) -> Result<JobRecord, Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        self.0.job_without_result(owner, id).await
    }

    /// The result of a job alone, to the byte as the planner wrote it; `None` while there is none.
    pub async fn result(&self, owner: &Owner, id: &str) -> Result<Option<Box<RawValue>>, Error> {
        Ok(self.job(owner, id).await?.result)
    }

    /// At most `limit` jobs (1 to [`crate::store::MAX_PAGE`]) that `filter` lets through, without their
    /// results, newest first, from where the page that answered `cursor` ended.
    pub async fn jobs(
        &self,
        filter: &JobFilter,
        limit: u32,
        cursor: Option<&str>,
    ) -> Result<JobPage, Error> {
        let page = self.0.store.jobs(filter, cursor, limit).await?;
        let mut page = page.ok_or(Error::InvalidCursor)?;
        for job in &mut page.jobs {
            self.0.shared.running.refresh(job);
        }
        Ok(page)
    }

    /// Stops a job: one that waits at once, one that runs within 0.2 s, keeping what it has found if it
    /// hands that in by then. Answers the job without its result and whether there was anything left to stop.
    pub async fn cancel(&self, owner: &Owner, id: &str) -> Result<(JobRecord, bool), Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let store = &inner.store;
            let Some(mut job) = store.cancel(&owner, id).await? else {
                return Ok((inner.job_without_result(&owner, id).await?, false));
            };
            if let Some(control) = inner.stop(id, Stop::Cancel) {
                control.pass(job.revision);
            }
            inner.shared.running.refresh(&mut job);
            Ok((job, true))
        })
        .await
    }

    /// Cancels and forgets a job.
    pub async fn delete_job(&self, owner: &Owner, id: &str) -> Result<(), Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let store = &inner.store;
            if !store.delete_job(&owner, id).await? {
                return Err(inner.absent(&owner, id).await);
            }
            inner.stop(id, Stop::Discard);
            Ok(())
        })
        .await
    }
}

impl Inner {
    /// Has the run of a job stop that was cancelled or forgotten, should it be here, and tells whoever waits for it.
    /// After the row has changed, so that a worker entering the job sees one or the other.
    pub(super) fn stop(&self, job: JobId, stop: Stop) -> Option<Arc<Control>> {
        let Shared {
            running,
            changes,
            fence,
            ..
        } = &*self.shared;
        let control = match fence {
            Some(_) => running.expect_stop(job),
            None => running.of(job),
        };
        if let Some(control) = &control {
            control.raise(stop);
        }
        changes.stopped(job);
        control
    }

    /// The job that a submission made when it was made before.
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

    /// The request with its callback URL in normal form, if the server may call there.
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
            request: serde_json::to_string(request).map_err(bug)?,
            label: request.label.clone(),
            priority: request.priority,
            capacity: self.queue_capacity,
            share: self.quota.of(owner).queued,
            submission,
        })
    }

    fn queued(
        &self,
        owner: &Owner,
        outcome: Result<JobRecord, Refusal>,
    ) -> Result<JobRecord, Error> {
        if let Ok(job) = &outcome {
            self.shared.tell_queued();
            self.shared.metrics.jobs.submitted.inc();
            tracing::info!(job = %job.id, mesh = job.mesh_id, "job queued");
        }
        outcome.map_err(|refusal| self.refused(owner, refusal))
    }

    /// What a refusal of the store means to an owner.
    pub(super) fn refused(&self, owner: &Owner, refusal: Refusal) -> Error {
        let share = self.quota.of(owner);
        match refusal {
            Refusal::UnknownMesh => Error::UnknownMesh,
            Refusal::Submitted => Error::InFlight,
            Refusal::QueueFull => Error::QueueFull {
                retry_after_s: self.retry_after_s(),
            },
            Refusal::ShareUsed => Error::QueueQuotaUsed {
                share: share.queued.unwrap_or_default(),
                retry_after_s: self.retry_after_s(),
            },
            Refusal::RoomUsed => Error::MeshQuotaUsed {
                room: share.mesh_bytes.unwrap_or_default(),
            },
        }
    }

    /// Seconds until a place in the queue is likely to be free.
    fn retry_after_s(&self) -> u64 {
        // One place is free each time that a worker ends a job. While none has ended, or these
        // are longer ones, what runs now tells more.
        let pace = self.shared.pace().max(self.shared.running.longest());
        let wait = pace.as_secs() / self.workers.max(1) as u64;
        wait.clamp(1, MAX_RETRY_AFTER_S)
    }

    pub(super) async fn job_without_result(
        &self,
        owner: &Owner,
        id: JobId,
    ) -> Result<JobRecord, Error> {
        match self.store.job_without_result(owner, id).await? {
            Some(job) => self.now(job).await,
            None => Err(self.absent(owner, id).await),
        }
    }

    async fn job(&self, owner: &Owner, id: JobId) -> Result<JobRecord, Error> {
        match self.store.job(owner, id).await? {
            Some(job) => self.now(job).await,
            None => Err(self.absent(owner, id).await),
        }
    }

    /// A job as it was stored, brought up to the moment.
    async fn now(&self, mut job: JobRecord) -> Result<JobRecord, Error> {
        self.shared.running.refresh(&mut job);
        if job.request.get().contains("\"callback_url\"") {
            job.callback = self.store.callback(job.id).await?;
        }
        Ok(job)
    }

    /// Why a job is not here.
    async fn absent(&self, owner: &Owner, id: JobId) -> Error {
        match self.store.has_expired(owner, id).await {
            Ok(true) => Error::Gone,
            Ok(false) => Error::NotFound,
            Err(error) => error.into(),
        }
    }
}
