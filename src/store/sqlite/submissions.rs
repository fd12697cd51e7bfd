//! Keys of submissions.

use async_trait::async_trait;
use sqlx::sqlite::SqliteConnection;

use super::{Sqlite, now};
use crate::store::submissions::SUBMISSION_TIME;
use crate::store::{Earlier, Owner, StoreError, Submission, Submissions, rows};
use crate::wire::JobId;

/// Remembers that a submission made `job`. Says whether its key was free.
pub(super) async fn insert(
    submission: &Submission,
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
    .bind(submission.key.as_str())
    .bind(&submission.fingerprint[..])
    .bind(job.to_string())
    .bind(created_at)
    .bind(forgotten_before())
    .execute(transaction)
    .await?;
    Ok(done.rows_affected() > 0)
}

#[async_trait]
impl Submissions for Sqlite {
    async fn earlier(
        &self,
        owner: &Owner,
        submission: &Submission,
    ) -> Result<Option<Earlier>, StoreError> {
        let row: Option<(Vec<u8>, String)> = sqlx::query_as(
            "SELECT fingerprint, job FROM submissions \
             WHERE owner = ?1 AND key = ?2 AND created_at > ?3",
        )
        .bind(owner.as_str())
        .bind(submission.key.as_str())
        .bind(forgotten_before())
        .fetch_optional(&self.readers)
        .await?;
        let Some((fingerprint, job)) = row else {
            return Ok(None);
        };
        Ok(Some(match fingerprint == submission.fingerprint {
            true => Earlier::Same(rows::job_id(&job)?),
            false => Earlier::Other,
        }))
    }
}

/// Keys used before this moment are free again.
pub(super) fn forgotten_before() -> i64 {
    now().saturating_sub(SUBMISSION_TIME.as_micros() as i64)
}
