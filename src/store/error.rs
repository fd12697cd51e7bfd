//! The errors of a store.

use std::io;
use std::path::PathBuf;

/// Why a call failed. It left no trace.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// No room on the disk.
    #[error("the disk is full")]
    Full,
    /// The database does not answer, or refuses.
    #[error("database: {0}")]
    Database(sqlx::Error),
    /// A file cannot be read or written.
    #[error("file: {0}")]
    File(io::Error),
    /// The database takes no writes.
    #[error("{0}")]
    Unwritable(&'static str),
    /// A record is not what was written.
    #[error("damaged record: {0}")]
    Damaged(String),
}

/// `disk_full` of PostgreSQL.
const POSTGRES_FULL: &str = "53100";
/// `SQLITE_FULL`: no room for a write; `SQLITE_IOERR_SHMSIZE`: none for the index of the write-ahead log.
const SQLITE_FULL: [&str; 2] = ["13", "4874"];

impl From<sqlx::Error> for StoreError {
    fn from(error: sqlx::Error) -> Self {
        let code = error.as_database_error().and_then(|error| error.code());
        match code.as_deref() {
            Some(code) if SQLITE_FULL.contains(&code) || code == POSTGRES_FULL => Self::Full,
            _ => Self::Database(error),
        }
    }
}

impl From<io::Error> for StoreError {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::Full,
            _ => Self::File(error),
        }
    }
}

/// Why the store cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Another server holds the lock of this directory.
    #[error("the data directory {} is in use by another graspd; stop that one, or give this one a directory of its own", .0.display())]
    InUse(PathBuf),
    /// The directory or a file in it cannot be created, read or written.
    #[error("the data directory {} cannot be used: {source}", .path.display())]
    Directory { path: PathBuf, source: io::Error },
    /// The SQLite library is too old to be trusted.
    #[error(
        "SQLite {found} is linked; {needed} or later is needed, earlier ones can corrupt a write-ahead log"
    )]
    OldSqlite { found: String, needed: String },
    /// SQLite did not take a setting that durability rests on.
    #[error("SQLite runs with {pragma} = {found}; {needed} is needed to keep what is acknowledged")]
    Pragma {
        pragma: &'static str,
        found: String,
        needed: &'static str,
    },
    /// The tables cannot be brought to the version that this program needs.
    #[error("the database graspd.db cannot be brought up to date: {0}")]
    Migrate(#[from] sqlx::migrate::MigrateError),
    /// The tables have had some of the migrations that were put together into one, and not all.
    #[error(
        "the tables are of a graspd before the last one, which alone can bring them up to date; start that one once"
    )]
    PartlyMigrated,
    /// Any other fault of the database.
    #[error("the database graspd.db cannot be opened: {0}")]
    Database(#[from] sqlx::Error),
    /// This is not the address of a database.
    #[error("--store: {0}; give an address such as postgres://user:password@host:5432/database")]
    Url(sqlx::Error),
    /// The database refuses the connection.
    #[error(
        "the database cannot be opened: {0}; check the address in --store, and whom the database lets in"
    )]
    Unreachable(sqlx::Error),
    /// The database does not answer.
    #[error("the database has not answered for {} s; check the address in --store, and whether the database runs", .0.as_secs())]
    Silent(std::time::Duration),
    /// The tables cannot be brought to the version that this program needs.
    #[error(
        "the tables in the database cannot be brought up to date: {0}; the user of --store needs the right to create a schema"
    )]
    MigratePostgres(sqlx::migrate::MigrateError),
    /// Other sessions do not let go of the tables.
    #[error("other sessions have held tables that must be brought up to date for {} s; look in pg_locks for a transaction that was forgotten", .0.as_secs())]
    Locked(std::time::Duration),
    /// The tables are those of a much later program.
    #[error(
        "the tables in the database are of a later graspd: they work with version {oldest} and later, and this program knows {known}; use a later graspd"
    )]
    TooOld { known: i64, oldest: i64 },
    /// Any other fault of a database that is shared.
    #[error(
        "the database cannot be prepared: {0}; the user of --store needs the right to create a schema"
    )]
    Postgres(sqlx::Error),
    /// Leftovers of the last run cannot be cleared away.
    #[error("leftovers of the last run cannot be cleared away: {0}")]
    Sweep(#[from] StoreError),
}
