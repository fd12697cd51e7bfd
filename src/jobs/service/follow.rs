//! Waiting for news of a job.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{Instant, timeout_at};

use super::{Inner, Service};
use crate::jobs::changes::Subscription;
use crate::jobs::error::Error;
use crate::jobs::owner_limits::Permit;
use crate::store::Owner;
use crate::wire::{JobId, JobRecord};

/// Longest that a change in the store goes unnoticed which was made elsewhere: where one process has it, and where
/// others tell of what they change and the lookout looks for what it did not hear.
const LOOK_AGAIN: Duration = Duration::from_secs(1);
const LOOK_AGAIN_SHARED: Duration = Duration::from_secs(10);

/// Follows one job. Costs nothing while the job does not change but one read of its record a second, or where other
/// processes share the store, of its revision together with those of all jobs that are followed here.
pub struct Follower {
    inner: Arc<Inner>,
    news: Subscription,
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
    /// Follows a job from here on. One of [`Error::TooManyFollowers`] places is taken until the follower
    /// is dropped.
    pub async fn follow(&self, owner: &Owner, id: &str) -> Result<Follower, Error> {
        let id = JobId::parse(id).ok_or(Error::NotFound)?;
        let inner = Arc::clone(&self.0);
        // In this order: a change that comes while the record is read leads to another reading.
        let news = inner.shared.changes.subscribe(id);
        let (change, read_at) = (news.stored(), Instant::now());
        let stored = inner.job_without_result(owner, id).await?;
        let permit = inner
            .followers
            .acquire(owner)
            .ok_or(Error::TooManyFollowers)?;
        Ok(Follower {
            inner,
            news,
            owner: owner.clone(),
            id,
            stored,
            change,
            read_at,
            _permit: permit,
        })
    }

    /// The job without its result as soon as it is `enough`, or as it is when `time` is over or the server
    /// stops.
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
    /// The job as it stands, without its result.
    pub fn current(&self) -> JobRecord {
        let mut job = self.stored.clone();
        self.inner.shared.running.refresh(&mut job);
        job
    }

    /// The job without its result as soon as its revision is past `seen`, whatever came in between; `None`
    /// when the server stops. Fails when the job was forgotten, the key revoked, and when the store cannot be
    /// read.
    pub async fn next_after(&mut self, seen: u64) -> Result<Option<JobRecord>, Error> {
        let look_again = match self.inner.shared.fence {
            None => LOOK_AGAIN,
            Some(_) => LOOK_AGAIN_SHARED,
        };
        loop {
            // Progress may come without a pause.
            if self.read_at.elapsed() >= look_again {
                self.read().await?;
            }
            let job = self.current();
            if job.revision > seen {
                return Ok(Some(job));
            }
            let stopping = &self.inner.shared.stopping;
            let heard = timeout_at(self.read_at + look_again, self.news.hear());
            let Some(heard) = stopping.run_until_cancelled(heard).await else {
                return Ok(None);
            };
            if heard.is_err() || self.news.stored() != self.change {
                self.read().await?;
            }
        }
    }

    async fn read(&mut self) -> Result<(), Error> {
        self.change = self.news.stored();
        self.read_at = Instant::now();
        if !self.inner.store.is_good(&self.owner).await? {
            return Err(Error::KeyRevoked);
        }
        self.stored = self.inner.job_without_result(&self.owner, self.id).await?;
        Ok(())
    }
}
