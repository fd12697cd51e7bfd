//! Keys of submissions.

use async_trait::async_trait;

use super::connections::Transaction;
use super::{Sqlite, now};
use crate::store::common::submissions::{REMEMBERED, SubmissionEngine};
use crate::store::{Owner, StoreError, Submission};
use crate::wire::JobId;

#[async_trait]
impl SubmissionEngine for Sqlite {
    async fn submitted_under(
        &self,
        owner: &Owner,
        key: &str,
    ) -> Result<Option<(Vec<u8>, String)>, StoreError> {
        let statement = sqlx::query(
            "SELECT fingerprint, job FROM submissions \
             WHERE owner = $1 AND key = $2 AND created_at > $3",
        )
        .bind(owner.as_str())
        .bind(key)
        .bind(forgotten_before());
        self.readers.read(statement).await?.first()
    }
}

/// Remembers that a submission made `job`. Returns whether its key was free.
pub(super) async fn insert(
    submission: &Submission,
    owner: &Owner,
    job: JobId,
    created_at: i64,
    transaction: &mut Transaction,
) -> Result<bool, StoreError> {
    let statement = sqlx::query(
        "INSERT INTO submissions (owner, key, fingerprint, job, created_at) \
         VALUES ($1, $2, $3, $4, $5) ON CONFLICT (owner, key) DO UPDATE SET \
         fingerprint = excluded.fingerprint, job = excluded.job, \
         created_at = excluded.created_at WHERE created_at <= $6",
    )
    .bind(owner.as_str())
    .bind(submission.key.as_str())
    .bind(&submission.fingerprint[..])
    .bind(job.to_string())
    .bind(created_at)
    .bind(forgotten_before());
    Ok(transaction.run(statement).await?.changed() > 0)
}

/// Keys used before this moment are free again.
pub(super) fn forgotten_before() -> i64 {
    now().saturating_sub(REMEMBERED)
}
