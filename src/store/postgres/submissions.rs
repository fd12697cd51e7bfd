//! Keys of submissions.

use async_trait::async_trait;
use sqlx::postgres::PgConnection;

use super::Postgres;
use crate::store::submissions::SUBMISSION_TIME;
use crate::store::{Earlier, Owner, StoreError, Submission, Submissions, rows};
use crate::wire::JobId;

/// Remembers that a submission made `job`. Says whether its key was free.
pub(super) async fn insert(
    submission: &Submission,
    owner: &Owner,
    job: JobId,
    connection: &mut PgConnection,
) -> Result<bool, StoreError> {
    let done = sqlx::query(
        "INSERT INTO submissions (owner, key, fingerprint, job, created_at) \
         VALUES ($1, $2, $3, $4, now_us()) ON CONFLICT (owner, key) DO UPDATE SET \
         fingerprint = excluded.fingerprint, job = excluded.job, \
         created_at = excluded.created_at WHERE submissions.created_at <= now_us() - $5",
    )
    .bind(owner.as_str())
    .bind(submission.key.as_str())
    .bind(&submission.fingerprint[..])
    .bind(job.to_string())
    .bind(remembered())
    .execute(connection)
    .await?;
    Ok(done.rows_affected() > 0)
}

#[async_trait]
impl Submissions for Postgres {
    async fn earlier(
        &self,
        owner: &Owner,
        submission: &Submission,
    ) -> Result<Option<Earlier>, StoreError> {
        let row: Option<(Vec<u8>, String)> = sqlx::query_as(
            "SELECT fingerprint, job FROM submissions \
             WHERE owner = $1 AND key = $2 AND created_at > now_us() - $3",
        )
        .bind(owner.as_str())
        .bind(submission.key.as_str())
        .bind(remembered())
        .fetch_optional(&self.reads)
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

/// How long a key is remembered, in microseconds.
pub(super) fn remembered() -> i64 {
    SUBMISSION_TIME.as_micros() as i64
}
