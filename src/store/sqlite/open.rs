//! Opening a data directory: lock, settings, tables, leftovers.

use std::collections::HashSet;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use sqlx::Row;
use sqlx::sqlite::{
    SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous,
};

use super::connections::Connections;
use super::files::Files;
use super::lock::{database_file, lock};
use super::migrations;
use super::reserve::Reserve;
use super::{Sqlite, SqliteKeys, blocking};
use crate::metrics::{Operation, StoreMetrics};
use crate::store::OpenError;
use crate::wire::MeshId;

/// EarlierSubmission releases have a bug that can corrupt a write-ahead log.
const OLDEST_SQLITE: [u32; 3] = [3, 51, 3];
/// Connections for reading.
const READERS: u32 = 4;
/// How long a call waits for a free connection before it fails.
const PATIENCE: Duration = Duration::from_secs(5);

impl Sqlite {
    /// Opens the store in `data`, creating what is missing and clearing away what a crash left
    /// behind. Takes time proportional to the number of meshes.
    pub async fn open(data: &Path) -> Result<Self, OpenError> {
        std::fs::create_dir_all(data).map_err(|fault| unusable(data, fault))?;
        let lock = lock(data)?;
        let files = Files::open(data).map_err(|fault| unusable(data, fault))?;

        let reserve = Reserve::open(data);
        let (writer, readers) = match connect(data).await {
            // On a full disk not even an up-to-date database can be opened.
            Err(_) if reserve.spend() => connect(data).await?,
            connected => connected?,
        };
        let metrics = StoreMetrics::default();
        let store = Self {
            writer: Connections::new(writer, &metrics, Operation::Write),
            readers: Connections::new(readers, &metrics, Operation::Read),
            files,
            metrics,
            reserve,
            probe: Arc::default(),
            mesh_change: Arc::default(),
            _lock: Arc::new(lock),
        };
        store.sweep().await?;
        store.release_webhooks().await?;
        Ok(store)
    }

    /// Makes rows and files agree again: a crash can leave a file whose row was not written or
    /// was already deleted, and uploads that never ended.
    async fn sweep(&self) -> Result<(), OpenError> {
        let files = self.files.clone();
        let on_disk = blocking(move || {
            files.clear_uploads()?;
            files.list()
        })
        .await?;
        let known = self
            .readers
            .read(sqlx::query("SELECT DISTINCT id FROM meshes"))
            .await?;
        let known: Vec<(String,)> = known.all()?;
        let known: HashSet<String> = known.into_iter().map(|(id,)| id).collect();
        let (kept, orphans): (HashSet<MeshId>, Vec<MeshId>) = {
            let (kept, orphans): (Vec<_>, Vec<_>) = on_disk
                .into_iter()
                .partition(|id| known.contains(id.as_str()));
            (kept.into_iter().collect(), orphans)
        };
        if !orphans.is_empty() {
            tracing::info!(
                count = orphans.len(),
                "removing mesh files without a record"
            );
            let files = self.files.clone();
            blocking(move || orphans.iter().try_for_each(|id| files.remove(id))).await?;
        }
        for id in known {
            if MeshId::parse(&id).is_none_or(|id| !kept.contains(&id)) {
                // Without its row the mesh can be uploaded again.
                tracing::error!(mesh = id, "the file of a mesh is gone; forgetting the mesh");
                let forget = sqlx::query("DELETE FROM meshes WHERE id = $1");
                self.writer.run(forget.bind(id)).await?;
            }
        }
        Ok(())
    }
}

impl SqliteKeys {
    /// Opens the keys in `data`, beside a server that uses it or not; makes the folder and the database when
    /// they are missing.
    pub async fn open(data: &Path) -> Result<Self, OpenError> {
        std::fs::create_dir_all(data).map_err(|fault| unusable(data, fault))?;
        let lock = match lock(data) {
            Ok(lock) => Some(lock),
            // The server that has it has brought the tables up to date.
            Err(OpenError::InUse(_)) => None,
            Err(fault) => return Err(fault),
        };
        let connection = pool(1).connect_with(database(data)).await?;
        if lock.is_some() {
            check_settings(&connection).await?;
            migrations::run(&connection).await?;
        }
        let metrics = StoreMetrics::default();
        Ok(Self {
            connection: Connections::new(connection, &metrics, Operation::Write),
        })
    }
}

/// Opens connections for writing and for reading, and brings the tables up to date.
async fn connect(data: &Path) -> Result<(SqlitePool, SqlitePool), OpenError> {
    let options = database(data);
    let writer = pool(1).connect_with(options.clone()).await?;
    check_settings(&writer).await?;
    migrations::run(&writer).await?;
    let readers = pool(READERS)
        .connect_with(options.create_if_missing(false).read_only(true))
        .await?;
    Ok((writer, readers))
}

/// The settings of a connection that writes.
fn database(data: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(database_file(data))
        .create_if_missing(true)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(PATIENCE)
}

fn pool(connections: u32) -> SqlitePoolOptions {
    SqlitePoolOptions::new()
        .min_connections(1)
        .max_connections(connections)
        .acquire_timeout(PATIENCE)
        .idle_timeout(None)
        .max_lifetime(None)
}

fn unusable(data: &Path, source: io::Error) -> OpenError {
    OpenError::Directory {
        path: data.to_owned(),
        source,
    }
}

/// Returns whether a write-ahead log is safe with this version of SQLite.
pub fn is_trusted_sqlite(version: &str) -> bool {
    let numbers = version.split('.').map_while(|part| part.parse().ok());
    numbers.collect::<Vec<u32>>().as_slice() >= OLDEST_SQLITE.as_slice()
}

/// Reads back the settings that durability rests on, instead of assuming them: killing the process would not show that
/// the store does not sync. Only a power cut would.
pub(super) async fn check_settings(writer: &SqlitePool) -> Result<(), OpenError> {
    let version: String = sqlx::query_scalar("SELECT sqlite_version()")
        .fetch_one(writer)
        .await?;
    if !is_trusted_sqlite(&version) {
        return Err(OpenError::OldSqlite {
            found: version,
            needed: OLDEST_SQLITE.map(|number| number.to_string()).join("."),
        });
    }
    for (pragma, statement, needed) in [
        ("journal_mode", "PRAGMA journal_mode", "wal"),
        ("synchronous", "PRAGMA synchronous", "2"),
        ("foreign_keys", "PRAGMA foreign_keys", "1"),
    ] {
        let row = sqlx::query(statement).fetch_one(writer).await?;
        let found = row
            .try_get::<String, _>(0)
            .or_else(|_| row.try_get::<i64, _>(0).map(|number| number.to_string()))?;
        if found != needed {
            return Err(OpenError::Pragma {
                pragma,
                found,
                needed,
            });
        }
    }
    Ok(())
}
