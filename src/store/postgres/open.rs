//! Connecting: settings of a session, tables brought up to date, and whether this program may use them.

use std::time::{Duration, Instant};

use sqlx::migrate::{MigrateError, Migrator};
use sqlx::postgres::{PgConnectOptions, PgConnection, PgPool, PgPoolOptions};
use sqlx::{ConnectOptions, Connection, Executor};
use tokio::time::timeout;
use uuid::Uuid;

use super::Postgres;
use super::connections::Connections;
use crate::metrics::{Operation, StoreMetrics};
use crate::store::OpenError;

/// Where everything is, so that the database may be shared with others.
const SCHEMA: &str = "graspd";
/// Longest that the database is waited for at the start.
const START_TIME: Duration = Duration::from_secs(30);
const START_PAUSE: Duration = Duration::from_secs(1);
/// Longest that sessions are waited for which hold what the tables are brought up to date with.
const LOCKS_TIME: Duration = Duration::from_secs(300);
const LOCK_NOT_AVAILABLE: &str = "55P03";
/// How long a connection may be idle before it is asked whether it is still one, and before it is closed.
const TRUSTED: Duration = Duration::from_secs(1);
const IDLE: Duration = Duration::from_secs(60);
/// Longest that an idle connection is waited for when it is asked.
const PING_TIME: Duration = Duration::from_secs(1);
/// Longest that a statement about leases is waited for: there has to be time for another try before they end.
const PULSE_TIME: Duration = Duration::from_secs(3);

/// The tables, version by version.
pub static MIGRATIONS: Migrator = sqlx::migrate!("src/store/postgres/migrations");

/// How many connections a process may have open at a time; idle ones are closed after a minute. One more listens,
/// and one keeps leases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sizes {
    pub reads: u32,
    pub writes: u32,
}

impl Sizes {
    /// Of a process that serves clients, with so many workers.
    pub fn of_server(workers: usize) -> Self {
        Self {
            reads: 6,
            writes: 4 + for_workers(workers),
        }
    }

    /// Of a process that only plans.
    pub fn of_worker(workers: usize) -> Self {
        Self {
            reads: 1,
            writes: for_workers(workers),
        }
    }
}

/// A worker needs one twice a job, for a millisecond.
fn for_workers(workers: usize) -> u32 {
    u32::try_from(workers.div_ceil(8)).unwrap_or(u32::MAX)
}

impl Postgres {
    /// Connects to the database at `url` (`postgres://USER:PASSWORD@HOST:PORT/DATABASE`), waiting half a minute for one
    /// that does not answer yet, and brings the tables up to date. Many may do that at the same moment.
    pub async fn open(url: &str, sizes: Sizes) -> Result<Self, OpenError> {
        let options = options(url)?;
        prepare(&options).await?;
        let metrics = StoreMetrics::default();
        let connections = |most: u32, operation: Operation| {
            Connections::new(pool(&options, most), &metrics, operation)
        };
        Ok(Self {
            reads: connections(sizes.reads, Operation::Read),
            writes: connections(sizes.writes, Operation::Write),
            pulse: connections(1, Operation::Write).patient(PULSE_TIME),
            sender: Uuid::new_v4().as_u128() as u32,
            options,
            metrics,
        })
    }
}

/// How a session is opened.
pub(super) fn options(url: &str) -> Result<PgConnectOptions, OpenError> {
    check(url)?;
    let options: PgConnectOptions = url.parse().map_err(OpenError::Url)?;
    Ok(options.application_name("graspd").options([
        ("search_path", SCHEMA),
        ("client_min_messages", "warning"),
        // Whoever was stopped in the midst of something keeps nobody waiting for long.
        ("statement_timeout", "15s"),
        ("idle_in_transaction_session_timeout", "5s"),
        // A peer that is gone without a word is missed within half a minute.
        ("tcp_keepalives_idle", "15"),
        ("tcp_keepalives_interval", "5"),
        ("tcp_keepalives_count", "3"),
        // What is acknowledged is on stable storage, whatever the database is set to.
        ("synchronous_commit", "on"),
    ]))
}

/// Refuses what would be taken for something else: another kind of database, and a misspelt setting, such as one that
/// was to have the certificate verified.
fn check(address: &str) -> Result<(), OpenError> {
    const SETTINGS: [&str; 10] = [
        "sslmode",
        "sslrootcert",
        "sslcert",
        "sslkey",
        "host",
        "port",
        "dbname",
        "user",
        "password",
        "statement-cache-capacity",
    ];
    let refuse = |why: String| OpenError::Url(sqlx::Error::Configuration(why.into()));
    let url = url::Url::parse(address).map_err(|fault| refuse(fault.to_string()))?;
    if !matches!(url.scheme(), "postgres" | "postgresql") {
        return Err(refuse(format!("{} is no PostgreSQL", url.scheme())));
    }
    match url
        .query_pairs()
        .find(|(name, _)| !SETTINGS.contains(&&**name))
    {
        Some((name, _)) => Err(refuse(format!("there is no setting {name}"))),
        None => Ok(()),
    }
}

fn pool(options: &PgConnectOptions, most: u32) -> PgPool {
    PgPoolOptions::new()
        .max_connections(most)
        .idle_timeout(IDLE)
        .test_before_acquire(false)
        .before_acquire(|connection, told| {
            Box::pin(async move {
                if told.idle_for < TRUSTED {
                    return Ok(true);
                }
                let ping = timeout(PING_TIME, connection.ping()).await;
                Ok(ping.is_ok_and(|answer| answer.is_ok()))
            })
        })
        .connect_lazy_with(options.clone())
}

/// Makes the tables, or brings them up to date.
async fn prepare(options: &PgConnectOptions) -> Result<(), OpenError> {
    // It may take long.
    let patient = options.clone().options([("statement_timeout", "0")]);
    let mut connection = connect(&patient).await?;
    // All begin at the same moment: one after the other, until the connection is closed. Behind this lock nobody waits
    // but they. Behind what the tables are changed with the service waits, so that is asked for in steps. Where the
    // schema is there, nobody needs the right to make it.
    let begin = format!(
        "SELECT pg_advisory_lock(hashtext('{SCHEMA}')); SET lock_timeout = '2s'; \
         DO $$ BEGIN IF to_regnamespace('{SCHEMA}') IS NULL THEN CREATE SCHEMA {SCHEMA}; END IF; END $$"
    );
    connection
        .execute(sqlx::raw_sql(sqlx::AssertSqlSafe(begin)))
        .await
        .map_err(OpenError::Postgres)?;
    let mut migrations = Migrator {
        migrations: MIGRATIONS.migrations.clone(),
        ..Migrator::DEFAULT
    };
    // Those of a later program, beside which this one may work.
    migrations.set_ignore_missing(true);
    let clock = Instant::now();
    while let Err(error) = migrations.run(&mut connection).await {
        if !is_lock(&error) {
            return Err(OpenError::MigratePostgres(error));
        }
        if clock.elapsed() > LOCKS_TIME {
            return Err(OpenError::Locked(LOCKS_TIME));
        }
        tracing::warn!("another session holds the tables, which are to be brought up to date");
        tokio::time::sleep(START_PAUSE).await;
    }
    let oldest: i64 = sqlx::query_scalar("SELECT oldest FROM compatibility")
        .fetch_one(&mut connection)
        .await
        .map_err(OpenError::Postgres)?;
    let known = known_version();
    let _ = connection.close().await;
    match oldest <= known {
        true => Ok(()),
        false => Err(OpenError::TooOld { known, oldest }),
    }
}

async fn connect(options: &PgConnectOptions) -> Result<PgConnection, OpenError> {
    let connect = async {
        loop {
            match options.connect().await {
                Ok(connection) => return Ok(connection),
                Err(error) if is_passing(&error) => {
                    tracing::warn!(%error, "the database does not answer yet");
                }
                // Such as a wrong password.
                Err(error) => return Err(error),
            }
            tokio::time::sleep(START_PAUSE).await;
        }
    };
    match timeout(START_TIME, connect).await {
        Ok(connected) => connected.map_err(OpenError::Unreachable),
        Err(_) => Err(OpenError::Silent(START_TIME)),
    }
}

/// Whether a lock was not given in time.
fn is_lock(error: &MigrateError) -> bool {
    let (MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _)) = error else {
        return false;
    };
    let code = error.as_database_error().and_then(|error| error.code());
    code.is_some_and(|code| code == LOCK_NOT_AVAILABLE)
}

/// The version of the tables that this program knows.
pub(super) fn known_version() -> i64 {
    let versions = MIGRATIONS.iter().map(|migration| migration.version);
    versions.max().unwrap_or(0)
}

/// Whether the database may take connections in a moment.
fn is_passing(error: &sqlx::Error) -> bool {
    match error {
        sqlx::Error::Io(_) => true,
        // cannot_connect_now, too_many_connections
        error => error
            .as_database_error()
            .and_then(|error| error.code())
            .is_some_and(|code| matches!(&*code, "57P03" | "53300")),
    }
}
