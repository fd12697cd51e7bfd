//! What is kept on disk: rows in SQLite, mesh files beside it.
//!
//! A data directory holds `lock`, `graspd.db` with its write-ahead log, `meshes/` and
//! `uploads/`. One process at a time has it. All writes go through one connection, each a single
//! guarded statement or an immediate transaction, so that none ever finds the database busy;
//! reads have connections of their own and never wait for a write.

mod backup;
mod cursor;
mod error;
mod files;
mod jobs;
mod keys;
mod lease;
mod meshes;
mod metered;
mod open;
mod owner;
mod reserve;
mod retention;
mod submissions;
mod survey;
#[cfg(test)]
mod tests;
mod webhooks;

use std::fs::File;
use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use sqlx::sqlite::{SqliteArguments, SqliteRow};

pub use backup::{BackupError, Contents, back_up, restore};
pub use error::{OpenError, StoreError};
pub use files::{Received, Upload};
pub use jobs::{JobFilter, NewJob, Refusal};
pub use keys::{KeyRecord, Keys, NewKey};
pub use lease::{Claim, Ending, Hold, Lease};
pub use meshes::{Deletion, NewMesh};
pub use open::is_trusted_sqlite;
pub use owner::Owner;
pub use retention::Expired;
pub use submissions::{Earlier, Submission};
pub use survey::{Survey, is_in_use, known_schema_version, lock_file};
pub use webhooks::{Attempt, Delivery};

use crate::metrics::StoreMetrics;
use files::Files;
use metered::Metered;
use reserve::Reserve;

/// Most items of one page of a list.
pub const MAX_PAGE: u32 = 1000;

/// How old the last write may be that shows that the store can be written.
const PROBE_EVERY: Duration = Duration::from_secs(5);

/// Everything that outlives the process. Clones share the same connections; the directory is
/// free for another process once the last one is gone.
#[derive(Debug, Clone)]
pub struct Store {
    writer: Metered,
    readers: Metered,
    files: Files,
    metrics: StoreMetrics,
    reserve: Reserve,
    /// Held while a write is tried out.
    probe: Arc<tokio::sync::Mutex<()>>,
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
        sqlx::query("SELECT 1 FROM jobs LIMIT 1")
            .execute(&self.readers)
            .await?;
        Ok(())
    }

    /// Fails unless the database can be written. Where nothing has been written for some seconds,
    /// one page is.
    pub async fn check_writable(&self) -> Result<(), StoreError> {
        let proven = || {
            let written = self.writer.written();
            written.is_some_and(|at| at.elapsed() < PROBE_EVERY)
        };
        if proven() {
            return Ok(());
        }
        let _one = self.probe.lock().await;
        if !proven() {
            // Nobody reads that number, but it is written and synced as all else.
            sqlx::query("PRAGMA user_version = 1")
                .execute(&self.writer)
                .await?;
            self.writer.note_written();
        }
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
