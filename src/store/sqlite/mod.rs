//! A store in a folder: rows in SQLite, mesh files beside it.
//!
//! A data directory holds `lock`, `graspd.db` with its write-ahead log, `meshes/` and
//! `uploads/`. One process at a time has it. All writes go through one connection, each a single
//! guarded statement or an immediate transaction, so that none ever finds the database busy;
//! reads have connections of their own and never wait for a write.
//!
//! The clock of the machine may be set back at any moment: no time is written that comes before the
//! one it follows.

mod backup;
mod batches;
mod files;
mod health;
mod jobs;
mod keys;
mod leases;
mod meshes;
mod metered;
mod notices;
mod open;
mod reserve;
mod retention;
mod submissions;
mod survey;
#[cfg(test)]
mod tests;
mod webhooks;

use std::fs::File;
use std::sync::Arc;

use jiff::Timestamp;
use sqlx::sqlite::{SqliteArguments, SqliteRow};

pub use backup::{BackupError, Contents, back_up, restore};
pub use keys::SqliteKeys;
pub use open::is_trusted_sqlite;
pub use survey::{Survey, is_in_use, known_schema_version, lock_file};

use super::StoreError;
use crate::metrics::StoreMetrics;
use files::Files;
use metered::Metered;
use reserve::Reserve;

/// A store in a data directory. Clones share the same connections; the directory is
/// free for another process once the last one is gone.
#[derive(Debug, Clone)]
pub struct Sqlite {
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

impl Sqlite {
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
