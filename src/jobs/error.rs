//! Why the service refuses a request, or cannot start.

use crate::store::{OpenError, StoreError};
use crate::wire::Problem;

/// Why a call of [`super::Service`] was refused. A refused call has changed nothing.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// 404: no such mesh or job.
    #[error("not found")]
    NotFound,
    /// 410: the job has expired, or was deleted after this submission made it.
    #[error("gone")]
    Gone,
    /// 401: the API key was revoked, or has expired, while its owner waited.
    #[error("the API key is no longer valid")]
    KeyRevoked,
    /// 409 with Retry-After: a submission under the same idempotency key is being carried out.
    #[error("a submission under this idempotency key is being carried out")]
    InFlight,
    /// 422: the idempotency key was used for another submission.
    #[error("this idempotency key was used for another submission")]
    KeyReused,
    /// 429 with Retry-After: as many jobs of this API key wait as may.
    #[error("as many jobs of this owner wait as may")]
    QueueQuotaUsed {
        /// Most that may wait.
        share: u32,
        /// Seconds until one of them is likely to be taken up.
        retry_after_s: u64,
    },
    /// 429 with Retry-After: the meshes of this API key take as much room as they may.
    #[error("the meshes of this owner take as much room as they may")]
    MeshQuotaUsed {
        /// Most bytes they may have.
        room: u64,
    },
    /// 409: a job that has not ended needs the mesh.
    #[error("a queued or running job uses this mesh")]
    MeshInUse,
    /// 400: not a cursor that this list has returned.
    #[error("not a cursor of this list")]
    InvalidCursor,
    /// 422 at `/mesh_id`: the job names a mesh that is not there.
    #[error("no such mesh")]
    UnknownMesh,
    /// 503 with Retry-After: as many jobs wait as may.
    #[error("the queue is full")]
    QueueFull {
        /// Seconds until one of them is likely to be taken up.
        retry_after_s: u64,
    },
    /// 503 with Retry-After: the server is about to stop.
    #[error("the server is shutting down")]
    Draining,
    /// 503 with Retry-After: a worker thread has ended; only a restart brings it back.
    #[error("a worker thread has ended")]
    WorkerLost,
    /// 503 with Retry-After: the process takes as much memory as it may.
    #[error("the server is out of memory")]
    OutOfMemory,
    /// 503 with Retry-After: as many clients follow jobs as may.
    #[error("too many clients follow jobs")]
    TooManyFollowers,
    /// 503 with Retry-After: new work cannot be done now.
    #[error("{detail}")]
    Unready {
        /// The last segment of the problem's type.
        kind: &'static str,
        detail: &'static str,
    },
    /// 415 or 422, as the problem says: the mesh cannot be used, or not with this request.
    #[error("{}", .0.detail)]
    Refused(Problem),
    /// 507 when the disk is full ([`StoreError::Full`]), else 503 with Retry-After.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// 500: a bug.
    #[error("{0}")]
    Bug(String),
}

impl Error {
    /// A failure that only a bug explains.
    pub(super) fn bug(error: impl std::fmt::Display) -> Self {
        Self::Bug(error.to_string())
    }
}

/// Why the service cannot start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The data directory cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The jobs of the last process cannot be put back in the queue.
    #[error("the jobs that the last process left running cannot be recovered: {0}")]
    Recover(#[from] StoreError),
    /// The operating system provides no more threads.
    #[error("the worker threads cannot be started: {0}")]
    Threads(String),
    /// TLS cannot be set up.
    #[error("TLS cannot be set up for webhooks: {0}")]
    Tls(tokio_rustls::rustls::Error),
}
