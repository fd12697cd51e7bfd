//! Jobs read, listed, cancelled, deleted.

use std::sync::Arc;

use serde_json::value::RawValue;

use super::state::{Inner, Service};
use crate::cluster::RunStop;
use crate::jobs::context::Context;
use crate::jobs::control::Control;
use crate::jobs::error::Error;
use crate::store::{JobFilter, Owner};
use crate::wire::{JobId, JobPage, JobRecord};

impl Service {
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
            if let Some(control) = inner.stop_run(id, RunStop::Cancel) {
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
            inner.stop_run(id, RunStop::Discard);
            Ok(())
        })
        .await
    }
}

impl Inner {
    /// Stops the run of a job that was cancelled or deleted, if it is here, and announces that to those who follow it.
    ///
    /// Call it after the record in the store has changed: a worker that enters the job meanwhile looks there.
    pub(super) fn stop_run(&self, job: JobId, reason: RunStop) -> Option<Arc<Control>> {
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
