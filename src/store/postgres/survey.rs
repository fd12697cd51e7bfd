//! A database that is examined without a change.

use std::time::{Duration, Instant};

use sqlx::{ConnectOptions, Connection};
use tokio::time::timeout;

use super::migrations::{self, VERSION};
use super::open;
use crate::store::OpenError;

/// How long the database is waited for.
const PATIENCE: Duration = Duration::from_secs(5);

/// The state of a database.
#[derive(Debug, Clone)]
pub struct Survey {
    /// The version of PostgreSQL.
    pub version: String,
    /// The version of the tables; `None` when there are none yet.
    pub schema: Option<i64>,
    /// The version that this program knows.
    pub known: i64,
    /// The oldest program that the tables still work with.
    pub oldest: i64,
    pub connections: i64,
    pub max_connections: i64,
    /// The time of one statement, there and back.
    pub round_trip: Duration,
    /// The time by its clock, in microseconds since 1970.
    pub now: i64,
}

impl Survey {
    /// Examines the database at `url`.
    pub async fn of(url: &str) -> Result<Self, OpenError> {
        let options = open::options(url)?;
        match timeout(PATIENCE, examine(options)).await {
            Ok(found) => found.map_err(OpenError::Unreachable),
            Err(_) => Err(OpenError::Silent(PATIENCE)),
        }
    }
}

async fn examine(options: sqlx::postgres::PgConnectOptions) -> Result<Survey, sqlx::Error> {
    let mut connection = options.connect().await?;
    let (version, max_connections, connections): (String, i64, i64) = sqlx::query_as(
        "SELECT current_setting('server_version'), current_setting('max_connections')::bigint, \
         (SELECT count(*) FROM pg_stat_activity WHERE backend_type = 'client backend')",
    )
    .fetch_one(&mut connection)
    .await?;
    let has_tables: bool = sqlx::query_scalar(
        "SELECT to_regclass('_sqlx_migrations') IS NOT NULL AND to_regclass('compatibility') IS NOT NULL",
    )
    .fetch_one(&mut connection)
    .await?;
    let (schema, oldest) = match has_tables {
        false => (None, 0),
        true => {
            let schema = migrations::version(&mut connection).await?;
            let oldest = sqlx::query_scalar("SELECT max(oldest) FROM compatibility");
            (Some(schema), oldest.fetch_one(&mut connection).await?)
        }
    };
    let asked = Instant::now();
    let now: i64 =
        sqlx::query_scalar("SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::bigint")
            .fetch_one(&mut connection)
            .await?;
    let round_trip = asked.elapsed();
    connection.close().await?;
    Ok(Survey {
        version,
        schema,
        known: VERSION,
        oldest,
        connections,
        max_connections,
        round_trip,
        now,
    })
}
