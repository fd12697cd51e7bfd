//! Jobs submitted, on a mesh in the store or together with one.

use super::meshes::MeshUpload;
use super::state::{Inner, Service};
use crate::jobs::context::Context;
use crate::jobs::error::Error;
use crate::jobs::idempotency::IdempotencyKey;
use crate::jobs::ingest;
use crate::store::{EarlierSubmission, NewJob, Owner, Refusal, Submission};
use crate::wire::{FieldError, JobId, JobRecord, MeshId, PlanRequest, Problem};

/// Longest wait that a refused client is asked for, in seconds.
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
            let _slot = inner.slots.upload()?;
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
            let bodies = mesh.report.body_count as u64;
            ingest::check_fit(&request, candidates, bodies).map_err(Error::Refused)?;
            let job = inner.new_job(&owner, &request, submission)?;
            let outcome = inner.store.add_mesh_and_job(received, &mesh, &job).await?;
            inner.accepted(&owner, outcome)
        })
        .await
    }
}

impl Inner {
    /// Returns the job that a submission made when it was sent before.
    async fn earlier(
        &self,
        owner: &Owner,
        submission: Option<&Submission>,
    ) -> Result<Option<JobRecord>, Error> {
        match self.earlier_id(owner, submission).await? {
            None => Ok(None),
            Some(id) => {
                let job = self.job_without_result(owner, id).await;
                job.map(Some).map_err(was_deleted)
            }
        }
    }

    /// Returns the id of the job or batch that a submission made when it was sent before.
    pub(super) async fn earlier_id(
        &self,
        owner: &Owner,
        submission: Option<&Submission>,
    ) -> Result<Option<JobId>, Error> {
        let Some(submission) = submission else {
            return Ok(None);
        };
        match self.store.earlier_submission(owner, submission).await? {
            None => Ok(None),
            Some(EarlierSubmission::Other) => Err(Error::KeyReused),
            Some(EarlierSubmission::Same(id)) => Ok(Some(id)),
        }
    }

    async fn submit(
        &self,
        owner: &Owner,
        mesh_id: &MeshId,
        request: &PlanRequest,
        submission: Option<Submission>,
    ) -> Result<JobRecord, Error> {
        let kept = self.store.mesh_summary(owner, mesh_id).await?;
        let kept = kept.ok_or(Error::UnknownMesh)?;
        ingest::check_fit(request, kept.candidates, kept.bodies).map_err(Error::Refused)?;
        let mut request = request.clone();
        request.quality.units = request.quality.units.or(kept.units);
        let job = self.new_job(owner, &request, submission)?;
        let outcome = self.store.submit(mesh_id, &job).await?;
        self.accepted(owner, outcome)
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
            owner_capacity: self.quota(owner).queued,
            submission,
        })
    }

    /// Counts and announces a job that the store has accepted.
    fn accepted(
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
            Refusal::KeyInUse => Error::InFlight,
            Refusal::QueueFull => Error::QueueFull {
                retry_after_s: self.retry_after_s(),
            },
            Refusal::OwnerQueueFull => Error::QueueQuotaUsed {
                share: quota.queued.unwrap_or_default(),
                retry_after_s: self.retry_after_s(),
            },
            Refusal::OwnerStorageFull => Error::MeshQuotaUsed {
                room: quota.mesh_bytes.unwrap_or_default(),
            },
        }
    }

    /// Returns after how many seconds there is likely to be room in the queue.
    fn retry_after_s(&self) -> u64 {
        // There is room for one more each time that a worker ends a job. While none has ended, or the running jobs are longer
        // than the last ones, their age says more.
        let Context { queue, running, .. } = &*self.context;
        let pace = queue.pace().max(running.longest());
        let wait = pace.as_secs() / self.limits.workers.max(1) as u64;
        wait.clamp(1, MAX_RETRY_AFTER_S)
    }
}

/// Turns `NotFound` into `Gone`: what a submission made and does not exist was deleted.
pub(super) fn was_deleted(error: Error) -> Error {
    match error {
        Error::NotFound => Error::Gone,
        error => error,
    }
}
