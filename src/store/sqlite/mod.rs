//! A store in a folder: rows in SQLite, mesh files beside it.
//!
//! A data directory holds `lock`, `graspd.db` with its write-ahead log, `graspd.db-reserve`, `meshes/` and `uploads/`.
//!
//! # Who may write, and when
//!
//! - One process at a time has the directory: it holds a lock on `lock` until it ends, however it ends. `graspd keys`
//!   and `graspd backup` may work beside it. `keys` only adds and revokes keys and marks jobs as cancelled.
//! - All writes of the process go through one connection, `writer`. Each is a single guarded statement, such as
//!   `UPDATE ... WHERE state = 'running' AND lease = ...`, or a transaction that begins with `BEGIN IMMEDIATE`. So
//!   none finds the database busy, and none has to be repeated because of another one.
//! - Reads have four connections of their own, and never wait for a write: in write-ahead mode each statement sees what
//!   was committed before it began.
//! - No transaction lasts as long as a job or waits for a client.
//! - The file and the row of a mesh change under `mesh_change`, so that an upload and a deletion of the same
//!   mesh cannot interleave into a row without a file.
//!
//! # What survives
//!
//! - What a call acknowledges survives the death of the process and a power cut: SQLite syncs its log at every commit
//!   (`synchronous = FULL`), and mesh files and their folder are synced before their row is written. These settings are
//!   read back at the start, because only a power cut would show that one was not taken.
//! - A statement that writes is run to its very end before it is acknowledged, since only its end commits.
//! - A crash can leave a file without a row, never a row without its file. The start removes such files, and uploads
//!   that never ended. It also takes every running job and every delivery from its holder, which is dead.
//! - Writes that were promised, such as a cancellation or the end of a run, have room set aside on the disk: see
//!   `reserve.rs`.
//! - The clock of the machine may be set back at any moment. No time is written that comes before the one it follows.

mod backup;
mod batches;
mod connections;
mod files;
mod health;
mod jobs;
mod keys;
mod leases;
mod lock;
mod meshes;
mod migrations;
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
use sqlx::sqlite::SqliteArguments;

pub use backup::{BackupError, Contents, back_up, restore};
pub use keys::SqliteKeys;
pub use lock::{is_in_use, lock_file};
pub use migrations::VERSION;
pub use open::is_trusted_sqlite;
pub use survey::Survey;

use super::StoreError;
use super::common::{self, Engine, Record};
use crate::metrics::StoreMetrics;
use connections::Connections;
use files::Files;
use reserve::Reserve;

/// A store in a data directory. Clones share connections; the directory is free for another process once the last
/// one is dropped.
#[derive(Debug, Clone)]
pub struct Sqlite {
    /// The one connection that writes.
    writer: Connections,
    readers: Connections,
    files: Files,
    metrics: StoreMetrics,
    reserve: Reserve,
    /// Held while one caller finds out whether the store can be written.
    probe: Arc<tokio::sync::Mutex<()>>,
    /// Held while the file and the row of a mesh change together.
    mesh_change: Arc<tokio::sync::Mutex<()>>,
    _lock: Arc<File>,
}

impl Engine for Sqlite {
    const IN_LIST: (&'static str, &'static str) = (" IN (SELECT value FROM json_each(", "))");

    async fn read<T: Record>(
        &self,
        statement: common::statement::Statement,
    ) -> Result<Vec<T>, StoreError> {
        self.readers.read(statement.for_sqlite()?).await?.all()
    }

    async fn change(&self, statement: common::statement::Statement) -> Result<u64, StoreError> {
        let change = || async {
            let statement = statement.clone().for_sqlite()?;
            Ok(self.writer.run(statement).await?.changed())
        };
        self.with_reserve(change).await
    }
}

impl Engine for SqliteKeys {
    const IN_LIST: (&'static str, &'static str) = Sqlite::IN_LIST;

    async fn read<T: Record>(
        &self,
        statement: common::statement::Statement,
    ) -> Result<Vec<T>, StoreError> {
        self.connection.read(statement.for_sqlite()?).await?.all()
    }

    async fn change(&self, statement: common::statement::Statement) -> Result<u64, StoreError> {
        let statement = statement.for_sqlite()?;
        Ok(self.connection.run(statement).await?.changed())
    }
}

/// A statement with its parameters.
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

/// The time by the clock of this machine, in microseconds since 1970.
fn now() -> i64 {
    Timestamp::now().as_microsecond()
}
