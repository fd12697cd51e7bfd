//! Batches: submitted, read, cancelled, deleted.

use std::collections::HashSet;
use std::time::Duration;

use tokio::time::Instant;

use super::state::{Inner, Service};
use super::submissions::was_deleted;
use crate::cluster::RunStop;
use crate::jobs::error::Error;
use crate::jobs::idempotency::IdempotencyKey;
use crate::jobs::ingest;
use crate::store::{BatchedJob, NewBatch, Owner, Refusal, Submission};
use crate::wire::{
    BatchId, BatchJob, BatchPage, BatchRecord, BatchRequest, BatchResult, BatchState, FieldError,
    JobState, MeshId, Problem,
};

/// Results that are read at the same time; each may be megabytes.
const RESULTS: u32 = 16;

impl Service {
    /// Queues all jobs of a batch or none; they are on stable storage once this returns. A repeated submission returns
    /// the batch that the first one made. Other submissions wait meanwhile, some tenths of a second for 10,000 jobs.
    pub async fn submit_batch(
        &self,
        owner: &Owner,
        batch: BatchRequest,
        key: Option<IdempotencyKey>,
    ) -> Result<BatchRecord, Error> {
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let submission = key.as_ref().map(IdempotencyKey::batch_submission);
            if let Some(batch) = inner.earlier_batch(&owner, submission.as_ref()).await? {
                return Ok(batch);
            }
            inner.check_open()?;
            inner.check_size(&owner, &batch)?;
            inner.check_room().await?;
            inner.submit_batch(&owner, &batch, submission).await
        })
        .await
    }

    /// Returns a batch as it is now.
    pub async fn batch(&self, owner: &Owner, id: &str) -> Result<BatchRecord, Error> {
        let id = BatchId::parse(id).ok_or(Error::NotFound)?;
        self.0.batch(owner, id).await
    }

    /// Waits until a batch has ended, for `time` at most or until the server stops, and returns it. Counts as a follower
    /// meanwhile ([`Error::TooManyFollowers`]).
    pub async fn wait_for_batch(
        &self,
        owner: &Owner,
        id: &str,
        time: Duration,
    ) -> Result<BatchRecord, Error> {
        let id = BatchId::parse(id).ok_or(Error::NotFound)?;
        let deadline = Instant::now() + time;
        loop {
            let batch = self.0.batch(owner, id).await?;
            let left = deadline.saturating_duration_since(Instant::now());
            if batch.state == BatchState::Ended || left.is_zero() {
                return Ok(batch);
            }
            let Some(job) = self.0.store.unfinished(id).await? else {
                continue;
            };
            let job = job.to_string();
            let ended = self.wait_for_job(owner, &job, left, |job| job.state.is_final());
            match ended.await {
                Ok(job) if job.state.is_final() => {}
                // Deleted meanwhile: there may be others.
                Err(Error::NotFound | Error::Gone) => {}
                Ok(_) => return self.0.batch(owner, id).await,
                Err(error) => return Err(error),
            }
        }
    }

    /// Returns at most `limit` batches (1 to [`crate::store::MAX_PAGE`]), newest first, from where the page that returned
    /// `cursor` ended.
    pub async fn batches(
        &self,
        owner: &Owner,
        limit: u32,
        cursor: Option<&str>,
    ) -> Result<BatchPage, Error> {
        let page = self.0.store.batches(owner, cursor, limit).await?;
        page.ok_or(Error::InvalidCursor)
    }

    /// Returns the results of the next few jobs of a batch after the one at index `after`, in its order; only of those in
    /// `state`, if given. An empty list is the end.
    pub async fn batch_results(
        &self,
        owner: &Owner,
        id: BatchId,
        state: Option<JobState>,
        after: Option<u32>,
    ) -> Result<Vec<BatchResult>, Error> {
        let store = &self.0.store;
        Ok(store
            .batch_results(owner, id, state, after, RESULTS)
            .await?)
    }

    /// Cancels all jobs of a batch, as [`Service::cancel`] does one. Returns the batch and whether any job was left to
    /// cancel.
    pub async fn cancel_batch(
        &self,
        owner: &Owner,
        id: &str,
    ) -> Result<(BatchRecord, bool), Error> {
        let id = BatchId::parse(id).ok_or(Error::NotFound)?;
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let changed = inner.store.cancel_batch(&owner, id).await?;
            for (job, revision) in &changed {
                if let Some(control) = inner.stop_run(*job, RunStop::Cancel) {
                    control.held.skip_to(*revision);
                }
            }
            Ok((inner.batch(&owner, id).await?, !changed.is_empty()))
        })
        .await
    }

    /// Cancels and deletes a batch and its jobs.
    pub async fn delete_batch(&self, owner: &Owner, id: &str) -> Result<(), Error> {
        let id = BatchId::parse(id).ok_or(Error::NotFound)?;
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let Some(jobs) = inner.store.delete_batch(&owner, id).await? else {
                return Err(inner.absent_batch(&owner, id).await);
            };
            for job in jobs {
                inner.stop_run(job, RunStop::Discard);
            }
            Ok(())
        })
        .await
    }
}

impl Inner {
    /// Returns the batch that a submission made when it was sent before.
    async fn earlier_batch(
        &self,
        owner: &Owner,
        submission: Option<&Submission>,
    ) -> Result<Option<BatchRecord>, Error> {
        match self.earlier_id(owner, submission).await? {
            None => Ok(None),
            Some(id) => {
                let batch = self.batch(owner, id.into()).await;
                batch.map(Some).map_err(was_deleted)
            }
        }
    }

    /// Refuses a batch for which an empty queue has too little room.
    fn check_size(&self, owner: &Owner, batch: &BatchRequest) -> Result<(), Error> {
        let jobs = batch.jobs.len();
        let quota = self.quota(owner).queued.unwrap_or(u32::MAX);
        let capacity = self.limits.queue_capacity;
        let (most, whose) = match quota < capacity {
            true => (quota, "of one key may wait"),
            false => (capacity, "may wait on this server"),
        };
        if jobs as u64 <= u64::from(most) {
            return Ok(());
        }
        let detail = format!(
            "{jobs} jobs are more than ever fit: at most {most} {whose}; submit them as several batches"
        );
        Err(invalid(vec![FieldError {
            pointer: batch.list_pointer().to_owned(),
            detail,
        }]))
    }

    async fn submit_batch(
        &self,
        owner: &Owner,
        batch: &BatchRequest,
        submission: Option<Submission>,
    ) -> Result<BatchRecord, Error> {
        let new = NewBatch {
            owner: owner.clone(),
            label: batch.label.clone(),
            jobs: self.jobs_of(owner, batch).await?,
            capacity: self.limits.queue_capacity,
            owner_capacity: self.quota(owner).queued,
            submission,
        };
        match self.store.submit_batch(&new).await? {
            Ok(record) => {
                self.context.changes.announce_queued();
                let jobs = &self.context.metrics.jobs;
                jobs.submitted.inc_by(record.jobs.total.into());
                tracing::info!(batch = %record.id, jobs = record.jobs.total, "batch queued");
                Ok(record)
            }
            // A mesh was deleted just now: say which.
            Err(Refusal::UnknownMesh) => {
                self.jobs_of(owner, batch).await?;
                Err(Error::UnknownMesh)
            }
            Err(refusal) => Err(self.refused(owner, refusal)),
        }
    }

    /// Returns the jobs of a batch in the form in which they are queued, unless a mesh does not exist or some settings
    /// cannot be used.
    async fn jobs_of(&self, owner: &Owner, batch: &BatchRequest) -> Result<Vec<BatchedJob>, Error> {
        let named: HashSet<MeshId> = batch
            .jobs
            .iter()
            .filter_map(|job| MeshId::parse(&job.mesh_id))
            .collect();
        let named: Vec<MeshId> = named.into_iter().collect();
        let meshes = self.store.mesh_summaries(owner, &named).await?;
        let (mut jobs, mut faults) = (Vec::with_capacity(batch.jobs.len()), Vec::new());
        for (index, BatchJob { mesh_id, request }) in batch.jobs.iter().enumerate() {
            let mesh = MeshId::parse(mesh_id).and_then(|id| Some((meshes.get(&id)?, id)));
            let Some((kept, mesh_id)) = mesh else {
                faults.push(FieldError {
                    pointer: batch.mesh_pointer(index),
                    detail: "no such mesh; upload it with POST /meshes".to_owned(),
                });
                continue;
            };
            let request = match self.with_callback(request.clone()) {
                Err(Error::Refused(problem)) => {
                    faults.extend(at(&batch.settings_pointer(index), &problem));
                    continue;
                }
                request => request?,
            };
            if let Err(problem) = ingest::check_fit(&request, kept.candidates, kept.bodies) {
                faults.extend(at(&batch.settings_pointer(index), &problem));
                continue;
            }
            let mut request = request;
            request.quality.units = request.quality.units.or(kept.units);
            jobs.push(BatchedJob {
                mesh_id,
                request: serde_json::to_string(&request).map_err(Error::bug)?,
                label: request.label,
                priority: request.priority,
            });
        }
        match faults.is_empty() {
            true => Ok(jobs),
            false => {
                // A request that all jobs share is at fault once.
                faults.dedup();
                Err(invalid(faults))
            }
        }
    }

    async fn batch(&self, owner: &Owner, id: BatchId) -> Result<BatchRecord, Error> {
        match self.store.batch(owner, id).await? {
            Some(batch) => Ok(batch),
            None => Err(self.absent_batch(owner, id).await),
        }
    }

    /// Returns why a batch does not exist.
    async fn absent_batch(&self, owner: &Owner, id: BatchId) -> Error {
        match self.store.batch_has_expired(owner, id).await {
            Ok(true) => Error::Gone,
            Ok(false) => Error::NotFound,
            Err(error) => error.into(),
        }
    }
}

fn invalid(faults: Vec<FieldError>) -> Error {
    Error::Refused(Problem::invalid(faults))
}

/// Returns the faults that a problem names, as faults of a part of the request.
fn at(part: &str, problem: &Problem) -> impl Iterator<Item = FieldError> {
    problem.errors.iter().map(move |fault| FieldError {
        pointer: format!("{part}{}", fault.pointer),
        detail: fault.detail.clone(),
    })
}
