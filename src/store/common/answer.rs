//! The whole answer of a database to a statement.

use futures_util::stream::{BoxStream, StreamExt};
use sqlx::{Database, Either, FromRow, Postgres, Sqlite};

use crate::store::StoreError;

/// A step of a statement: a row, or the end of one of its parts.
type Step<D> = Result<Either<<D as Database>::QueryResult, <D as Database>::Row>, sqlx::Error>;

/// The rows that a statement returned, and how many it changed.
#[derive(Debug)]
pub struct Answer<D: Database> {
    rows: Vec<D::Row>,
    result: D::QueryResult,
}

impl<D: Database> Answer<D> {
    /// Runs a statement to its very end, however few of its rows are wanted.
    ///
    /// Stopping at the first row would leave the commit of a statement that writes to the moment when SQLite resets
    /// it. A commit that fails there, such as on a full disk, is never reported.
    pub async fn collect(mut steps: BoxStream<'_, Step<D>>) -> Result<Self, sqlx::Error> {
        let (mut rows, mut result) = (Vec::new(), D::QueryResult::default());
        while let Some(step) = steps.next().await {
            match step? {
                Either::Left(done) => result.extend([done]),
                Either::Right(row) => rows.push(row),
            }
        }
        Ok(Self { rows, result })
    }

    /// Whether there is any row.
    pub fn has_rows(&self) -> bool {
        !self.rows.is_empty()
    }

    /// Returns the rows as records.
    pub fn all<T: for<'r> FromRow<'r, D::Row>>(&self) -> Result<Vec<T>, StoreError> {
        let records = self.rows.iter().map(|row| Ok(T::from_row(row)?));
        records.collect()
    }

    /// Returns the first row, if there is any.
    pub fn first<T: for<'r> FromRow<'r, D::Row>>(&self) -> Result<Option<T>, StoreError> {
        let row = self.rows.first().map(T::from_row);
        Ok(row.transpose()?)
    }

    /// Returns the row of a statement that always returns one.
    pub fn one<T: for<'r> FromRow<'r, D::Row>>(&self) -> Result<T, StoreError> {
        let row = self.first()?;
        row.ok_or(StoreError::Database(sqlx::Error::RowNotFound))
    }
}

impl Answer<Sqlite> {
    /// How many rows the statement changed or removed.
    pub fn changed(&self) -> u64 {
        self.result.rows_affected()
    }
}

impl Answer<Postgres> {
    /// How many rows the statement changed, removed or returned.
    pub fn changed(&self) -> u64 {
        self.result.rows_affected()
    }
}
