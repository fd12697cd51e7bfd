//! What both engines do alike: the flow of each call of the contract, the statements that read the same in both
//! dialects of SQL, and the records that rows stand for.
//!
//! Each subject has a trait such as `JobEngine` with what the engines do each in their own way: statements
//! that name the time, which is the clock of the process in a folder and that of the server in a shared database;
//! locks; and how files and results are kept. Whatever implements it has the whole subject of the contract.

pub mod answer;
pub mod batches;
pub mod cursor;
pub mod jobs;
pub mod keys;
pub mod leases;
pub mod meshes;
pub mod meter;
pub mod migrations;
pub mod retention;
pub mod rows;
pub mod statement;
pub mod submissions;
pub mod webhooks;

use sqlx::FromRow;
use sqlx::postgres::PgRow;
use sqlx::sqlite::SqliteRow;

use super::StoreError;
use statement::Statement;

/// The types as which a row of either engine can be read.
pub trait Record:
    for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin
{
}

impl<T> Record for T where
    T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin
{
}

/// An engine, as the shared flow uses it.
pub trait Engine: Send + Sync {
    /// How a column is compared with the texts of a list: what stands before the parameter, and what behind it.
    const IN_LIST: (&'static str, &'static str);

    /// Returns the rows of a statement that only reads.
    fn read<T: Record>(
        &self,
        statement: Statement,
    ) -> impl Future<Output = Result<Vec<T>, StoreError>> + Send;

    /// Runs a statement that removes or changes rows, and returns how many. It must not fail for want of room on
    /// the disk.
    fn change(&self, statement: Statement) -> impl Future<Output = Result<u64, StoreError>> + Send;
}

/// The first of the rows that a statement with one row at most returned.
pub async fn first<T: Record>(
    engine: &impl Engine,
    statement: Statement,
) -> Result<Option<T>, StoreError> {
    Ok(engine.read(statement).await?.into_iter().next())
}

/// The row of a statement that always returns one.
pub async fn one<T: Record>(engine: &impl Engine, statement: Statement) -> Result<T, StoreError> {
    let row = first(engine, statement).await?;
    row.ok_or(StoreError::Database(sqlx::Error::RowNotFound))
}
