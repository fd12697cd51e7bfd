//! Keys of submissions.

use async_trait::async_trait;

use super::{Engine, rows};
use crate::store::submissions::SUBMISSION_TIME;
use crate::store::{EarlierSubmission, Owner, StoreError, Submission, Submissions};

/// How long a key is remembered, in microseconds.
pub const REMEMBERED: i64 = SUBMISSION_TIME.as_secs() * 1_000_000;

/// The operations on idempotency keys that each engine implements itself.
#[async_trait]
pub trait SubmissionEngine: Engine {
    /// Returns the fingerprint of what was submitted under a key that is not free, and the job that it made.
    async fn submitted_under(
        &self,
        owner: &Owner,
        key: &str,
    ) -> Result<Option<(Vec<u8>, String)>, StoreError>;
}

#[async_trait]
impl<E: SubmissionEngine> Submissions for E {
    async fn earlier_submission(
        &self,
        owner: &Owner,
        submission: &Submission,
    ) -> Result<Option<EarlierSubmission>, StoreError> {
        let Some((fingerprint, job)) = self.submitted_under(owner, &submission.key).await? else {
            return Ok(None);
        };
        Ok(Some(match fingerprint == submission.fingerprint {
            true => EarlierSubmission::Same(rows::job_id(&job)?),
            false => EarlierSubmission::Other,
        }))
    }
}
