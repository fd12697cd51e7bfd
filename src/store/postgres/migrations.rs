//! The tables, version by version.

use std::time::{Duration, Instant};

use sqlx::migrate::{MigrateError, Migrator};
use sqlx::postgres::PgConnection;
use sqlx::{Connection, Executor};

use crate::store::OpenError;
use crate::store::common::migrations::{
    Applied, Before, DELETE_APPLIED, History, INSERT_APPLIED, SELECT_APPLIED,
};

/// The schema that has everything, so that the database may be shared with others.
pub const SCHEMA: &str = "graspd";

pub static MIGRATIONS: Migrator = sqlx::migrate!("src/store/postgres/migrations");

/// The version of the tables that this program knows.
pub const VERSION: i64 = 1;

/// The migrations that made these tables before they were put together into one.
const BEFORE: [Before; 2] = [(1, 0x808a_9be1_10dd_3709), (2, 0xab4b_efd1_6f60_0ecc)];

/// Longest time to wait for sessions that hold tables to be changed, and the pause between two tries.
const LOCKS_TIME: Duration = Duration::from_secs(300);
const LOCKS_PAUSE: Duration = Duration::from_secs(1);
const LOCK_NOT_AVAILABLE: &str = "55P03";

/// Makes the tables, or brings them up to date. Many processes may do so at the same moment: one after the other,
/// until the connection is closed.
pub async fn run(connection: &mut PgConnection, migrations: &Migrator) -> Result<(), OpenError> {
    // Behind the advisory lock nobody waits but other processes that start. Behind the locks on tables the service
    // waits, so that those are asked for in steps. Where the schema is there, nobody needs the right to make it.
    let begin = format!(
        "SELECT pg_advisory_lock(hashtext('{SCHEMA}')); SET lock_timeout = '2s'; \
         DO $$ BEGIN IF to_regnamespace('{SCHEMA}') IS NULL THEN CREATE SCHEMA {SCHEMA}; END IF; END $$"
    );
    connection
        .execute(sqlx::raw_sql(sqlx::AssertSqlSafe(begin)))
        .await
        .map_err(OpenError::Postgres)?;
    match history(connection).await.map_err(OpenError::Postgres)? {
        History::Version(_) => {}
        History::AllBefore => replace(connection).await.map_err(OpenError::Postgres)?,
        History::SomeBefore(_) => return Err(OpenError::PartlyMigrated),
    }
    let mut migrations = Migrator {
        migrations: migrations.migrations.clone(),
        ..Migrator::DEFAULT
    };
    // Those of a later program, beside which this one may work.
    migrations.set_ignore_missing(true);
    let clock = Instant::now();
    while let Err(error) = migrations.run(&mut *connection).await {
        if !is_lock(&error) {
            return Err(OpenError::MigratePostgres(error));
        }
        if clock.elapsed() > LOCKS_TIME {
            return Err(OpenError::Locked(LOCKS_TIME));
        }
        tracing::warn!("another session holds the tables, which are to be brought up to date");
        tokio::time::sleep(LOCKS_PAUSE).await;
    }
    Ok(())
}

/// The version of the tables in a database; 0 when there are none.
pub async fn version(connection: &mut PgConnection) -> Result<i64, sqlx::Error> {
    Ok(history(connection).await?.version(VERSION))
}

async fn history(connection: &mut PgConnection) -> Result<History, sqlx::Error> {
    let has_table: bool = sqlx::query_scalar("SELECT to_regclass('_sqlx_migrations') IS NOT NULL")
        .fetch_one(&mut *connection)
        .await?;
    let applied: Vec<Applied> = match has_table {
        false => Vec::new(),
        true => sqlx::query_as(SELECT_APPLIED).fetch_all(connection).await?,
    };
    Ok(History::of(&applied, &BEFORE))
}

/// Puts the one migration in the place of those before, all or nothing.
async fn replace(connection: &mut PgConnection) -> Result<(), sqlx::Error> {
    let mut transaction = connection.begin().await?;
    sqlx::query(DELETE_APPLIED)
        .execute(&mut *transaction)
        .await?;
    for migration in MIGRATIONS.iter().filter(|migration| migration.version == 1) {
        sqlx::query(INSERT_APPLIED)
            .bind(migration.version)
            .bind(&*migration.description)
            .bind(&*migration.checksum)
            .execute(&mut *transaction)
            .await?;
    }
    transaction.commit().await
}

/// Whether a lock was not given in time.
fn is_lock(error: &MigrateError) -> bool {
    let (MigrateError::Execute(error) | MigrateError::ExecuteMigration(error, _)) = error else {
        return false;
    };
    let code = error.as_database_error().and_then(|error| error.code());
    code.is_some_and(|code| code == LOCK_NOT_AVAILABLE)
}
