//! Connecting: settings of a session, tables brought up to date, and whether this program may use them.

use std::time::Duration;

use sqlx::migrate::Migrator;
use sqlx::postgres::{PgConnectOptions, PgConnection, PgPool, PgPoolOptions};
use sqlx::{ConnectOptions, Connection};
use tokio::time::timeout;
use uuid::Uuid;

use super::Postgres;
use super::connections::Connections;
use super::migrations::{self, MIGRATIONS, SCHEMA, VERSION};
use crate::metrics::{Operation, StoreMetrics};
use crate::store::OpenError;

/// Longest time to wait for the database at the start.
const START_TIME: Duration = Duration::from_secs(30);
const START_PAUSE: Duration = Duration::from_secs(1);
/// How long a connection may be idle before it is tested, and before it is closed.
const TRUSTED: Duration = Duration::from_secs(1);
const IDLE: Duration = Duration::from_secs(60);
/// Longest time to wait for the answer of an idle connection.
const PING_TIME: Duration = Duration::from_secs(1);
/// Longest time to wait for a statement about leases: there must be time for another try before they end.
const URGENT_TIME: Duration = Duration::from_secs(3);

/// How many connections a process may have open at a time; idle ones are closed after a minute. One more listens,
/// and one keeps leases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PoolSizes {
    pub reads: u32,
    pub writes: u32,
}

impl PoolSizes {
    /// The pools of a process that serves clients, with so many workers.
    pub fn of_server(workers: usize) -> Self {
        Self {
            reads: 6,
            writes: 4 + for_workers(workers),
        }
    }

    /// The pools of a process that only plans.
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
    pub async fn open(url: &str, sizes: PoolSizes) -> Result<Self, OpenError> {
        Self::open_with(url, sizes, &MIGRATIONS).await
    }

    pub(super) async fn open_with(
        url: &str,
        sizes: PoolSizes,
        migrations: &Migrator,
    ) -> Result<Self, OpenError> {
        let options = options(url)?;
        prepare(&options, migrations).await?;
        let metrics = StoreMetrics::default();
        let connections = |most: u32, operation: Operation| {
            Connections::new(pool(&options, most), &metrics, operation)
        };
        Ok(Self {
            reads: connections(sizes.reads, Operation::Read),
            writes: connections(sizes.writes, Operation::Write),
            urgent: connections(1, Operation::Write).patient(URGENT_TIME),
            sender: Uuid::new_v4().as_u128() as u32,
            options,
            metrics,
        })
    }
}

/// The settings of a session.
pub(super) fn options(url: &str) -> Result<PgConnectOptions, OpenError> {
    check(url)?;
    let options: PgConnectOptions = url.parse().map_err(OpenError::Url)?;
    Ok(options.application_name("graspd").options([
        ("search_path", SCHEMA),
        ("client_min_messages", "warning"),
        // A process that was stopped in the midst of something keeps nobody waiting for long.
        ("statement_timeout", "15s"),
        ("idle_in_transaction_session_timeout", "5s"),
        // A peer that vanished is noticed within half a minute.
        ("tcp_keepalives_idle", "15"),
        ("tcp_keepalives_interval", "5"),
        ("tcp_keepalives_count", "3"),
        // What is acknowledged is on stable storage, whatever the database is set to.
        ("synchronous_commit", "on"),
    ]))
}

/// Refuses an address that would mean something else: another kind of database, or a misspelt setting, such as one that
/// should have had the certificate verified.
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
        .before_acquire(|connection, state| {
            Box::pin(async move {
                if state.idle_for < TRUSTED {
                    return Ok(true);
                }
                let ping = timeout(PING_TIME, connection.ping()).await;
                Ok(ping.is_ok_and(|answer| answer.is_ok()))
            })
        })
        .connect_lazy_with(options.clone())
}

/// Makes the tables, or brings them up to date, and fails where they are too new for this program.
async fn prepare(options: &PgConnectOptions, migrations: &Migrator) -> Result<(), OpenError> {
    // It may take long.
    let patient = options.clone().options([("statement_timeout", "0")]);
    let mut connection = connect(&patient).await?;
    migrations::run(&mut connection, migrations).await?;
    let oldest: i64 = sqlx::query_scalar("SELECT oldest FROM compatibility")
        .fetch_one(&mut connection)
        .await
        .map_err(OpenError::Postgres)?;
    let _ = connection.close().await;
    match oldest <= VERSION {
        true => Ok(()),
        false => Err(OpenError::TooOld {
            known: VERSION,
            oldest,
        }),
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

/// Returns whether the database may take connections in a moment.
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
