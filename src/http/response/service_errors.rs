//! The errors of the service as problems.

use super::error::Error;
use crate::http::layers::rate_limit::RateLimitState;
use crate::jobs::{self, StoreError};
use crate::wire::Problem;

/// Seconds after which a client may try again when nothing better is known.
const RETRY_AFTER_S: u64 = 5;
/// The same for room on the disk, which only comes free when meshes expire or are deleted.
const ROOM_RETRY_AFTER_S: u64 = 60;

impl From<jobs::Error> for Error {
    fn from(error: jobs::Error) -> Self {
        match error {
            jobs::Error::NotFound => Self::not_found(),
            jobs::Error::Gone => Problem::new(
                410,
                "gone",
                "Gone",
                "this was here and has expired, or has been deleted; submit it again, under another \
                 Idempotency-Key",
            )
            .into(),
            jobs::Error::KeyRevoked => Self::unauthorized("this API key was revoked or has expired"),
            jobs::Error::InFlight => Self::conflict(
                "a submission under this Idempotency-Key is under way; send it again in a moment",
            )
            .retry_after(1),
            jobs::Error::KeyReused => Problem::new(
                422,
                "idempotency-key-reused",
                "Idempotency-Key used before",
                "another request was submitted under this Idempotency-Key in the last 24 hours; use a new \
                 key for a new request",
            )
            .into(),
            jobs::Error::QueueQuotaUsed {
                share,
                retry_after_s,
            } => Self::too_many(
                format!("{share} jobs of this key wait, and no more may; try again later"),
                quota("queued-jobs", share.into(), retry_after_s),
            ),
            jobs::Error::MeshQuotaUsed { room } => Self::too_many(
                format!(
                    "the meshes of this key may have {room} bytes in all; delete some, or wait until they expire"
                ),
                quota("mesh-bytes", room, ROOM_RETRY_AFTER_S),
            ),
            jobs::Error::MeshInUse => Self::conflict(
                "a queued or running job uses this mesh; cancel that job or wait for its end",
            ),
            jobs::Error::InvalidCursor => {
                Self::query("cursor", "not a next_cursor that this list has answered")
            }
            jobs::Error::UnknownMesh => {
                Self::invalid_field("/mesh_id", "no such mesh; upload it with POST /meshes")
            }
            jobs::Error::QueueFull { retry_after_s } => {
                let detail = "as many jobs wait as may; try again later";
                Self::unavailable("queue-full", detail, retry_after_s)
            }
            jobs::Error::Draining => Self::unavailable(
                "draining",
                "the server is shutting down; try again later",
                RETRY_AFTER_S,
            ),
            jobs::Error::WorkerLost => Self::unavailable(
                "worker-lost",
                "a worker of the server is gone; it has to be restarted",
                RETRY_AFTER_S,
            ),
            jobs::Error::OutOfMemory => Self::unavailable(
                "out-of-memory",
                "the server is at the limit of its memory; try again later",
                RETRY_AFTER_S,
            ),
            jobs::Error::TooManyFollowers => Self::unavailable(
                "too-many-followers",
                "as many clients wait for news of jobs as may; read the job without wait, or try again later",
                RETRY_AFTER_S,
            ),
            jobs::Error::Unready { kind, detail } => Self::unavailable(kind, detail, RETRY_AFTER_S),
            jobs::Error::Refused(problem) => problem.into(),
            jobs::Error::Store(fault) => fault.into(),
            jobs::Error::Bug(cause) => Self::internal(cause),
        }
    }
}

/// The state of a quota that is used up.
fn quota(name: &'static str, limit: u64, reset_s: u64) -> RateLimitState {
    RateLimitState {
        name,
        limit,
        left: 0,
        window_s: None,
        reset_s,
    }
}

impl From<StoreError> for Error {
    fn from(fault: StoreError) -> Self {
        tracing::error!(%fault, "the store refused an operation");
        match fault {
            StoreError::Full => Self::disk_full(),
            _ => Self::unavailable(
                "store-unavailable",
                "the store is out of reach; try again later",
                RETRY_AFTER_S,
            ),
        }
    }
}
