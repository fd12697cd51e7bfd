//! What was submitted under an Idempotency-Key, so that a repeated submission makes no second job.

use jiff::SignedDuration;
use sqlx::Row;
use sqlx::sqlite::SqliteConnection;

use super::{Owner, Store, StoreError, damaged, now};
use crate::wire::JobId;

/// Longest that a key is remembered.
pub const SUBMISSION_TIME: SignedDuration = SignedDuration::from_hours(24);

/// A key of its sender's choice, and what is submitted under it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Submission {
    pub key: String,
    /// Hash of everything that the job depends on.
    pub fingerprint: [u8; 32],
}

/// What a key was used for before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Earlier {
    /// For the same, which made this job; it may have been deleted since.
    Same(JobId),
    /// For something else.
    Other,
}

impl Submission {
    /// Remembers that the submission made `job`. Says whether the key was free.
    pub(super) async fn insert(
        &self,
        owner: &Owner,
        job: JobId,
        created_at: i64,
        transaction: &mut SqliteConnection,
    ) -> Result<bool, StoreError> {
        let done = sqlx::query(
            "INSERT INTO submissions (owner, key, fingerprint, job, created_at) \
             VALUES (?1, ?2, ?3, ?4, ?5) ON CONFLICT (owner, key) DO UPDATE SET \
             fingerprint = excluded.fingerprint, job = excluded.job, \
             created_at = excluded.created_at WHERE created_at <= ?6",
        )
        .bind(owner.as_str())
        .bind(self.key.as_str())
        .bind(&self.fingerprint[..])
        .bind(job.to_string())
        .bind(created_at)
        .bind(forgotten_before())
        .execute(transaction)
        .await?;
        Ok(done.rows_affected() > 0)
    }
}

impl Store {
    /// What the key of a submission was used for in the last 24 hours; `None` when it is free.
    pub async fn earlier(
        &self,
        owner: &Owner,
        submission: &Submission,
    ) -> Result<Option<Earlier>, StoreError> {
        let row = sqlx::query(
            "SELECT fingerprint, job FROM submissions \
             WHERE owner = ?1 AND key = ?2 AND created_at > ?3",
        )
        .bind(owner.as_str())
        .bind(submission.key.as_str())
        .bind(forgotten_before())
        .fetch_optional(&self.readers)
        .await?;
        let Some(row) = row else {
            return Ok(None);
        };
        let (fingerprint, job): (&[u8], &str) = (row.try_get("fingerprint")?, row.try_get("job")?);
        let job = JobId::parse(job).ok_or_else(|| damaged("job id"))?;
        Ok(Some(match fingerprint == submission.fingerprint {
            true => Earlier::Same(job),
            false => Earlier::Other,
        }))
    }
}

/// Keys used before this moment are free again.
pub(super) fn forgotten_before() -> i64 {
    now().saturating_sub(SUBMISSION_TIME.as_micros() as i64)
}
