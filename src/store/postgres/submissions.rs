//! Keys of submissions.

use async_trait::async_trait;

use super::Postgres;
use super::connections::Transaction;
use crate::store::common::submissions::{REMEMBERED, SubmissionEngine};
use crate::store::{Owner, StoreError, Submission};
use crate::wire::JobId;

#[async_trait]
impl SubmissionEngine for Postgres {
    async fn submitted_under(
        &self,
        owner: &Owner,
        key: &str,
    ) -> Result<Option<(Vec<u8>, String)>, StoreError> {
        let statement = sqlx::query(
            "SELECT fingerprint, job FROM submissions \
             WHERE owner = $1 AND key = $2 AND created_at > now_us() - $3",
        );
        let statement = statement.bind(owner.as_str()).bind(key).bind(REMEMBERED);
        self.reads.run(statement).await?.first()
    }
}

/// Remembers that a submission made `job`. Returns whether its key was free.
pub(super) async fn insert(
    submission: &Submission,
    owner: &Owner,
    job: JobId,
    transaction: &mut Transaction,
) -> Result<bool, StoreError> {
    let statement = sqlx::query(
        "INSERT INTO submissions (owner, key, fingerprint, job, created_at) \
         VALUES ($1, $2, $3, $4, now_us()) ON CONFLICT (owner, key) DO UPDATE SET \
         fingerprint = excluded.fingerprint, job = excluded.job, \
         created_at = excluded.created_at WHERE submissions.created_at <= now_us() - $5",
    )
    .bind(owner.as_str())
    .bind(submission.key.as_str())
    .bind(&submission.fingerprint[..])
    .bind(job.to_string())
    .bind(REMEMBERED);
    Ok(transaction.run(statement).await?.changed() > 0)
}
