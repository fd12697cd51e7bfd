//! Connections whose statements are timed, counted, and not waited for without end.

use std::io;
use std::time::Duration;

use sqlx::Executor;
use sqlx::pool::PoolConnection;
use sqlx::postgres::{PgConnection, PgPool};
use tokio::time::timeout;

use super::Statement;
use crate::metrics::{Operation, StoreMetrics};
use crate::store::StoreError;
use crate::store::common::answer::Answer;
use crate::store::common::meter::{Meter, Timer};

/// Longest time to wait for a statement, including the wait for a connection.
pub const PATIENCE: Duration = Duration::from_secs(8);

type Database = sqlx::Postgres;

/// A pool of connections whose statements are timed, counted, and given up when the database does not answer.
/// Clones share connections.
#[derive(Debug, Clone)]
pub struct Connections {
    pool: PgPool,
    patience: Duration,
    meter: Meter,
}

impl Connections {
    pub fn new(pool: PgPool, metrics: &StoreMetrics, operation: Operation) -> Self {
        Self {
            pool,
            patience: PATIENCE,
            meter: Meter::new(metrics, operation),
        }
    }

    /// The same connections, whose statements are given up after this time.
    pub fn patient(self, patience: Duration) -> Self {
        Self { patience, ..self }
    }

    /// Runs a statement.
    pub async fn run(&self, statement: Statement<'_>) -> Result<Answer<Database>, sqlx::Error> {
        let mut timer = self.meter.start(true);
        let answer = self.acquire().await?.run(self.patience, statement).await?;
        timer.failed = false;
        Ok(answer)
    }

    /// Begins a transaction; timed until it ends. Only its begin is given up when the database does not answer:
    /// [`within`] bounds what is done in it.
    pub async fn begin(&self) -> Result<Transaction, sqlx::Error> {
        let timer = self.meter.start(true);
        let mut connection = self.acquire().await?;
        connection.run(self.patience, sqlx::query("BEGIN")).await?;
        connection.is_busy = true;
        Ok(Transaction { connection, timer })
    }

    /// Closes the connections.
    pub async fn close(&self) {
        self.pool.close().await;
    }

    async fn acquire(&self) -> Result<Held, sqlx::Error> {
        let connection = timeout(self.patience, self.pool.acquire());
        let connection = connection.await.map_err(|_| too_slow())??;
        Ok(Held {
            connection: Some(connection),
            is_busy: false,
        })
    }
}

/// A connection that goes back to its pool only between statements. One that was left in the midst of a statement,
/// by a caller that was dropped or by a database that did not answer, is closed, so that nobody waits for it again.
#[derive(Debug)]
struct Held {
    /// There until it is dropped.
    connection: Option<PoolConnection<Database>>,
    is_busy: bool,
}

impl Held {
    fn get(&mut self) -> &mut PgConnection {
        self.connection.as_mut().expect("held until it is dropped")
    }

    async fn run(
        &mut self,
        patience: Duration,
        statement: Statement<'_>,
    ) -> Result<Answer<Database>, sqlx::Error> {
        self.is_busy = true;
        let answer = Answer::collect(self.get().fetch_many(statement));
        let answer = timeout(patience, answer).await.map_err(|_| too_slow())?;
        // After an error that is not of the database, the connection is lost.
        self.is_busy = matches!(&answer, Err(error) if error.as_database_error().is_none());
        answer
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        if let Some(connection) = self.connection.take()
            && self.is_busy
        {
            drop(connection.detach());
        }
    }
}

/// A transaction that is timed from its begin to its end. One that was not brought to its end goes with its
/// connection.
#[derive(Debug)]
pub struct Transaction {
    connection: Held,
    timer: Timer,
}

impl Transaction {
    /// Runs a statement in it.
    pub async fn run(&mut self, statement: Statement<'_>) -> Result<Answer<Database>, sqlx::Error> {
        Answer::collect(self.connection.get().fetch_many(statement)).await
    }

    /// Ends it: keeps what was written, or takes it back.
    pub async fn end(mut self, keep: bool) -> Result<(), sqlx::Error> {
        let statement = if keep { "COMMIT" } else { "ROLLBACK" };
        self.run(sqlx::query(statement)).await?;
        self.connection.is_busy = false;
        self.timer.failed = false;
        Ok(())
    }
}

/// Gives up work in transactions when the database does not answer for long.
pub async fn within<T>(
    patience: Duration,
    work: impl Future<Output = Result<T, StoreError>>,
) -> Result<T, StoreError> {
    match timeout(patience, work).await {
        Ok(outcome) => outcome,
        Err(_) => Err(too_slow().into()),
    }
}

fn too_slow() -> sqlx::Error {
    let text = "the database does not answer in time";
    sqlx::Error::Io(io::Error::new(io::ErrorKind::TimedOut, text))
}
