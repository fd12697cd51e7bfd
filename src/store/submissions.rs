//! Keys of submissions: sent again, a submission makes no second job.

use async_trait::async_trait;
use jiff::SignedDuration;

use super::{Owner, StoreError};
use crate::wire::JobId;

/// How long a key is remembered.
pub const SUBMISSION_TIME: SignedDuration = SignedDuration::from_hours(24);

/// A key of its sender's choice, and what is submitted under it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Submission {
    pub key: String,
    /// A hash of everything that the job depends on.
    pub fingerprint: [u8; 32],
}

/// What a key was used for earlier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EarlierSubmission {
    /// The same request, which made this job; it may have been deleted since.
    Same(JobId),
    /// Another request.
    Other,
}

/// The submissions that a store remembers.
#[async_trait]
pub trait Submissions {
    /// Returns what the key of a submission was used for in the last 24 hours; `None` when it is free.
    async fn earlier_submission(
        &self,
        owner: &Owner,
        submission: &Submission,
    ) -> Result<Option<EarlierSubmission>, StoreError>;
}
