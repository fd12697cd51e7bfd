//! A database that is looked at and not changed.

use std::time::{Duration, Instant};

use sqlx::{ConnectOptions, Connection};
use tokio::time::timeout;

use super::open;
use crate::store::OpenError;

/// Longest that the database is waited for.
const PATIENCE: Duration = Duration::from_secs(5);

/// What is known of a database.
#[derive(Debug, Clone)]
pub struct Survey {
    /// Of PostgreSQL.
    pub version: String,
    /// Of the tables; `None` when there are none yet.
    pub schema: Option<i64>,
    /// What this program knows.
    pub known: i64,
    /// The oldest program that the tables still work with.
    pub oldest: i64,
    pub connections: i64,
    pub max_connections: i64,
    /// One statement, there and back.
    pub round_trip: Duration,
    /// Microseconds since 1970 by its clock.
    pub now: i64,
}

impl Survey {
    /// Looks at the database at `url`.
    pub async fn of(url: &str) -> Result<Self, OpenError> {
        let options = open::options(url)?;
        match timeout(PATIENCE, look(options)).await {
            Ok(found) => found.map_err(OpenError::Unreachable),
            Err(_) => Err(OpenError::Silent(PATIENCE)),
        }
    }
}

async fn look(options: sqlx::postgres::PgConnectOptions) -> Result<Survey, sqlx::Error> {
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
            sqlx::query_as(
                "SELECT (SELECT max(version) FROM _sqlx_migrations WHERE success), \
                 (SELECT max(oldest) FROM compatibility)",
            )
            .fetch_one(&mut connection)
            .await?
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
        known: open::known_version(),
        oldest,
        connections,
        max_connections,
        round_trip,
        now,
    })
}
