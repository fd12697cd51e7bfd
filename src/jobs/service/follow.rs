//! Follows jobs.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{Instant, timeout_at};

use super::state::{Inner, Service};
use crate::cluster::Subscription;
use crate::jobs::error::Error;
use crate::jobs::owner_limits::Permit;
use crate::store::Owner;
use crate::wire::{JobId, JobRecord};

/// Longest time until a change in the store is noticed if no process announces it, such as one made by hand.
const READ_AGAIN: Duration = Duration::from_secs(1);
/// The same on a shared store, which the listener of the cluster polls for all followers together.
const READ_AGAIN_SHARED: Duration = Duration::from_secs(10);

/// Follows one job. While the job does not change, this costs one read of its record a second; on a shared store, one
/// read of its revision, together with those of all jobs that are followed here.
pub struct Follower {
    inner: Arc<Inner>,
    subscription: Subscription,
    owner: Owner,
    id: JobId,
    /// The record as it was read from the store.
    stored: JobRecord,
    /// Which change of it that was.
    change: u64,
    read_at: Instant,
    _permit: Permit,
}

impl Service {
    /// Follows a job from here on. The number of followers is limited ([`Error::TooManyFollowers`]).
    pub async fn follow(&self, owner: &Owner, id: &str) -> Result<Follower, Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        let inner = Arc::clone(&self.0);
        // In this order: a change that comes while the record is read leads to another reading.
        let subscription = inner.context.changes.subscribe(id);
        let (change, read_at) = (subscription.record_changes(), Instant::now());
        let stored = inner.job_without_result(owner, id).await?;
        let permit = inner
            .followers
            .acquire(owner)
            .ok_or(Error::TooManyFollowers)?;
        Ok(Follower {
            inner,
            subscription,
            owner: owner.clone(),
            id,
            stored,
            change,
            read_at,
            _permit: permit,
        })
    }

    /// Waits until `enough` accepts the job, for `time` at most or until the server stops, and returns the job without
    /// its result.
    pub async fn wait_for_job(
        &self,
        owner: &Owner,
        id: &str,
        time: Duration,
        enough: impl Fn(&JobRecord) -> bool,
    ) -> Result<JobRecord, Error> {
        let job = self.job_without_result(owner, id).await?;
        if time.is_zero() || enough(&job) {
            return Ok(job);
        }
        let deadline = Instant::now() + time;
        let mut follower = self.follow(owner, id).await?;
        let mut job = follower.current();
        while !enough(&job) {
            match timeout_at(deadline, follower.next_after(job.revision)).await {
                Ok(Ok(Some(newer))) => job = newer,
                Ok(Err(error)) => return Err(error),
                Ok(Ok(None)) | Err(_) => return Ok(follower.current()),
            }
        }
        Ok(job)
    }
}

impl Follower {
    /// Returns the job as it is now, without its result.
    pub fn current(&self) -> JobRecord {
        let mut job = self.stored.clone();
        self.inner.context.running.refresh(&mut job);
        job
    }

    /// Waits until the revision of the job is greater than `seen` and returns the job without its result, or `None` when
    /// the server stops. Fails when the job was deleted, the API key revoked, or the store cannot be read.
    pub async fn next_after(&mut self, seen: u64) -> Result<Option<JobRecord>, Error> {
        let changes = &self.inner.context.changes;
        let read_again = match changes.coordinator().is_shared() {
            true => READ_AGAIN_SHARED,
            false => READ_AGAIN,
        };
        loop {
            // Here, too: progress may come without a pause.
            if self.read_at.elapsed() >= read_again {
                self.read().await?;
            }
            let job = self.current();
            if job.revision > seen {
                return Ok(Some(job));
            }
            let stopping = &self.inner.context.lifecycle.stopping;
            let changed = timeout_at(self.read_at + read_again, self.subscription.changed());
            let Some(changed) = stopping.run_until_cancelled(changed).await else {
                return Ok(None);
            };
            if changed.is_err() || self.subscription.record_changes() != self.change {
                self.read().await?;
            }
        }
    }

    async fn read(&mut self) -> Result<(), Error> {
        self.change = self.subscription.record_changes();
        self.read_at = Instant::now();
        if !self.inner.store.is_valid(&self.owner).await? {
            return Err(Error::KeyRevoked);
        }
        self.stored = self.inner.job_without_result(&self.owner, self.id).await?;
        Ok(())
    }
}
