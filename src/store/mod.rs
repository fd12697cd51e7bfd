//! What is kept on disk: rows in SQLite, mesh files beside it.
//!
//! A data directory holds `lock`, `graspd.db` with its write-ahead log, `meshes/` and
//! `uploads/`. One process at a time has it. All writes go through one connection, each a single
//! guarded statement or an immediate transaction, so that none ever finds the database busy;
//! reads have connections of their own and never wait for a write.

mod cursor;
mod error;
mod files;
mod jobs;
mod lease;
mod meshes;
mod metered;
mod open;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::sync::Arc;

use jiff::Timestamp;
use sqlx::sqlite::{SqliteArguments, SqliteRow};

pub use error::{OpenError, StoreError};
pub use files::{Received, Upload};
pub use jobs::{JobFilter, NewJob, Refusal};
pub use lease::{Claim, Ending, Hold, Lease};
pub use meshes::{Deletion, NewMesh};

use crate::metrics::StoreMetrics;
use files::Files;
use metered::Metered;

/// Most items of one page of a list.
pub const MAX_PAGE: u32 = 1000;

/// Everything that outlives the process. Clones share the same connections; the directory is
/// free for another process once the last one is gone.
#[derive(Debug, Clone)]
pub struct Store {
    writer: Metered,
    readers: Metered,
    files: Files,
    metrics: StoreMetrics,
    /// Held while the file and the row of a mesh change together, so that an upload and a
    /// deletion of the same mesh cannot interleave into a row without a file.
    mesh_change: Arc<tokio::sync::Mutex<()>>,
    _lock: Arc<File>,
}

impl Store {
    /// An empty file to receive a mesh into; it is removed unless it becomes one.
    pub async fn begin_upload(&self) -> Result<Upload, StoreError> {
        let (files, received) = (self.files.clone(), self.metrics.upload_bytes.clone());
        blocking(move || files.begin_upload(received)).await
    }

    /// The numbers of this store.
    pub fn metrics(&self) -> &StoreMetrics {
        &self.metrics
    }

    /// Fails unless the database answers.
    pub async fn ping(&self) -> Result<(), StoreError> {
        sqlx::query("SELECT 1").execute(&self.readers).await?;
        Ok(())
    }

    /// Closes the connections, waiting for statements under way.
    pub async fn close(&self) {
        self.readers.close().await;
        self.writer.close().await;
    }

    /// Runs a writing statement that returns rows to its very end.
    ///
    /// Stopping at the first row would leave the commit to the moment the statement is reset,
    /// and a commit that fails there, such as on a full disk, is never reported.
    async fn write_returning(
        &self,
        statement: Statement<'_>,
    ) -> Result<Vec<SqliteRow>, StoreError> {
        Ok(statement.fetch_all(&self.writer).await?)
    }
}

type Statement<'q> = sqlx::query::Query<'q, sqlx::Sqlite, SqliteArguments>;

/// Runs blocking file work off the async threads.
async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> std::io::Result<T> + Send + 'static,
) -> Result<T, StoreError> {
    match tokio::task::spawn_blocking(work).await {
        Ok(outcome) => Ok(outcome?),
        Err(stopped) => Err(StoreError::File(std::io::Error::other(stopped))),
    }
}

fn now() -> i64 {
    Timestamp::now().as_microsecond()
}

fn timestamp(microseconds: i64) -> Result<Timestamp, StoreError> {
    Timestamp::from_microsecond(microseconds)
        .map_err(|error| StoreError::Damaged(error.to_string()))
}

fn damaged(error: impl std::fmt::Display) -> StoreError {
    StoreError::Damaged(error.to_string())
}
