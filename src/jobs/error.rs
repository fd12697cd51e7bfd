//! Why the service refuses.

use crate::store::{OpenError, StoreError};
use crate::wire::Problem;

/// Why a call of [`super::Service`] was refused. Nothing has changed when it was.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// 404: no such mesh or job.
    #[error("not found")]
    NotFound,
    /// 410: the job was here and has expired, or was deleted after this submission made it.
    #[error("gone")]
    Gone,
    /// 401: the key was revoked, or has expired, while its owner waited.
    #[error("the key is no longer good")]
    KeyRevoked,
    /// 409 with Retry-After: a submission under the same key is being carried out.
    #[error("a submission under this key is under way")]
    InFlight,
    /// 422: the key was used for another submission.
    #[error("this key was used for something else")]
    KeyReused,
    /// 429 with Retry-After: as many jobs of this key wait as may.
    #[error("as many jobs of this owner wait as may")]
    QueueQuotaUsed {
        /// Most that may wait.
        share: u32,
        /// Seconds until a place is likely to be free.
        retry_after_s: u64,
    },
    /// 429 with Retry-After: the meshes of this key take as much room as they may.
    #[error("the meshes of this owner take as much room as they may")]
    MeshQuotaUsed {
        /// Most bytes they may have.
        room: u64,
    },
    /// 409: a job that has not ended needs the mesh.
    #[error("a queued or running job uses this mesh")]
    MeshInUse,
    /// 400: not a cursor that a list has answered.
    #[error("not a cursor of this list")]
    InvalidCursor,
    /// 422 at `/mesh_id`: the job names a mesh that is not there.
    #[error("no such mesh")]
    UnknownMesh,
    /// 503 with Retry-After: as many jobs wait as may.
    #[error("the queue is full")]
    QueueFull {
        /// Seconds until a place is likely to be free.
        retry_after_s: u64,
    },
    /// 503 with Retry-After: the server is about to stop.
    #[error("the server is shutting down")]
    Draining,
    /// 503 with Retry-After: a worker thread is gone; only a restart brings it back.
    #[error("a worker thread has ended")]
    WorkerLost,
    /// 503 with Retry-After: the process takes as much memory as it may.
    #[error("the server is out of memory")]
    OutOfMemory,
    /// 503 with Retry-After: as many clients wait for news of jobs as may.
    #[error("too many clients wait for news of jobs")]
    TooManyFollowers,
    /// 503 with Retry-After: new work could not be done now.
    #[error("{detail}")]
    Unready {
        /// The last segment of the problem's type.
        kind: &'static str,
        detail: &'static str,
    },
    /// As the problem says, 415 or 422: the mesh cannot be used, or not with this request.
    #[error("{}", .0.detail)]
    Refused(Problem),
    /// 507 when the disk is full ([`StoreError::Full`]), else 503 with Retry-After.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// 500: a bug.
    #[error("{0}")]
    Bug(String),
}

/// Why the service cannot start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The data directory cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The jobs of the last run cannot be put back in the queue.
    #[error("the jobs of the last run cannot be recovered: {0}")]
    Recover(#[from] StoreError),
    /// The system gives no threads.
    #[error("the worker threads cannot be started: {0}")]
    Threads(String),
    /// TLS cannot be set up.
    #[error("TLS cannot be set up for webhooks: {0}")]
    Tls(tokio_rustls::rustls::Error),
}
