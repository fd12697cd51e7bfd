//! The tables, version by version.

use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnection, SqlitePool};

use crate::store::OpenError;
use crate::store::common::migrations::{
    Applied, Before, DELETE_APPLIED, History, INSERT_APPLIED, SELECT_APPLIED,
};

static MIGRATIONS: Migrator = sqlx::migrate!("src/store/sqlite/migrations");

/// The version of the tables that this program needs.
pub const VERSION: i64 = 1;

/// The migrations that made these tables before they were put together into one.
const BEFORE: [Before; 6] = [
    (1, 0xaa47_a69b_5200_4c5e),
    (2, 0x0a61_90f5_2fe0_d55a),
    (3, 0x99da_bc0b_2955_753a),
    (4, 0x4d09_5a9d_0094_7690),
    (5, 0x3efa_1eab_b3cd_7ab0),
    (6, 0x1a05_79fb_abf3_0337),
];

/// Makes the tables, or brings them up to date.
pub async fn run(pool: &SqlitePool) -> Result<(), OpenError> {
    let mut connection = pool.acquire().await?;
    match history(&mut connection).await? {
        History::Version(_) => {}
        History::AllBefore => replace(&mut connection).await?,
        History::SomeBefore(_) => return Err(OpenError::PartlyMigrated),
    }
    drop(connection);
    Ok(MIGRATIONS.run(pool).await?)
}

/// The version of the tables in a database; 0 when there are none.
pub async fn version(connection: &mut SqliteConnection) -> Result<i64, sqlx::Error> {
    Ok(history(connection).await?.version(VERSION))
}

async fn history(connection: &mut SqliteConnection) -> Result<History, sqlx::Error> {
    let has_table: bool = sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM sqlite_master WHERE name = '_sqlx_migrations')",
    )
    .fetch_one(&mut *connection)
    .await?;
    let applied: Vec<Applied> = match has_table {
        false => Vec::new(),
        true => sqlx::query_as(SELECT_APPLIED).fetch_all(connection).await?,
    };
    Ok(History::of(&applied, &BEFORE))
}

/// Puts the one migration in the place of those before, all or nothing.
async fn replace(connection: &mut SqliteConnection) -> Result<(), sqlx::Error> {
    let mut transaction = sqlx::Connection::begin(connection).await?;
    for statement in ["ALTER TABLE stock RENAME TO job_counts", DELETE_APPLIED] {
        sqlx::query(statement).execute(&mut *transaction).await?;
    }
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
