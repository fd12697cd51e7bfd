//! Connections whose statements are timed and counted.

use std::sync::Arc;
use std::time::Instant;

use parking_lot::Mutex;
use sqlx::pool::PoolConnection;
use sqlx::sqlite::SqlitePool;
use sqlx::{Executor, Sqlite};

use super::Statement;
use crate::metrics::{Operation, StoreMetrics};
use crate::store::common::answer::Answer;
use crate::store::common::meter::{Meter, Timer};

/// A pool of connections that times every statement it runs, and remembers when it last wrote. Clones share
/// connections and memory.
#[derive(Debug, Clone)]
pub struct Connections {
    pool: SqlitePool,
    meter: Meter,
    /// When something was last written; `None` when a statement has failed since.
    written: Arc<Mutex<Option<Instant>>>,
}

impl Connections {
    pub fn new(pool: SqlitePool, metrics: &StoreMetrics, operation: Operation) -> Self {
        Self {
            pool,
            meter: Meter::new(metrics, operation),
            written: Arc::default(),
        }
    }

    /// When something was last written; `None` when a statement has failed since.
    pub fn written(&self) -> Option<Instant> {
        *self.written.lock()
    }

    /// Takes note of a write that changed no row.
    pub fn note_written(&self) {
        *self.written.lock() = Some(Instant::now());
    }

    /// Runs a statement that only reads.
    pub async fn read(&self, statement: Statement<'_>) -> Result<Answer<Sqlite>, sqlx::Error> {
        let mut timer = self.meter.start(false);
        let answer = Answer::collect((&self.pool).fetch_many(statement)).await;
        if answer.is_err() {
            self.note_failure(&mut timer);
        }
        answer
    }

    /// Runs a statement that may write.
    pub async fn run(&self, statement: Statement<'_>) -> Result<Answer<Sqlite>, sqlx::Error> {
        let answer = self.read(statement).await?;
        // A statement that finds nothing to change succeeds on a full disk too.
        if answer.changed() > 0 || answer.has_rows() {
            self.note_written();
        }
        Ok(answer)
    }

    /// Begins a transaction that writes; timed until it ends.
    pub async fn begin(&self) -> Result<Transaction, sqlx::Error> {
        let mut timer = self.meter.start(false);
        let begun = async {
            let mut connection = self.pool.acquire().await?;
            connection.execute("BEGIN IMMEDIATE").await?;
            Ok(connection)
        };
        let begun: Result<_, sqlx::Error> = begun.await;
        if begun.is_err() {
            self.note_failure(&mut timer);
        }
        Ok(Transaction {
            connection: begun?,
            is_open: true,
            timer,
            connections: self.clone(),
        })
    }

    /// Closes the connections.
    pub async fn close(&self) {
        self.pool.close().await;
    }

    fn note_failure(&self, timer: &mut Timer) {
        timer.failed = true;
        *self.written.lock() = None;
    }
}

/// A transaction that is timed from its begin to its end.
///
/// SQLite may end a transaction by itself when a write fails, as on a full disk, so it is unknown whether there is still
/// one to roll back. The connection of an unfinished transaction is therefore closed, which is right in both cases, and
/// another replaces it.
#[derive(Debug)]
pub struct Transaction {
    connection: PoolConnection<Sqlite>,
    is_open: bool,
    timer: Timer,
    connections: Connections,
}

impl Transaction {
    /// Runs a statement in it.
    pub async fn run(&mut self, statement: Statement<'_>) -> Result<Answer<Sqlite>, sqlx::Error> {
        Answer::collect((&mut *self.connection).fetch_many(statement)).await
    }

    /// Ends it: keeps what was written, or takes it back.
    pub async fn end(mut self, keep: bool) -> Result<(), sqlx::Error> {
        let statement = if keep { "COMMIT" } else { "ROLLBACK" };
        self.connection.execute(statement).await?;
        self.is_open = false;
        if keep {
            self.connections.note_written();
        }
        Ok(())
    }
}

impl Drop for Transaction {
    fn drop(&mut self) {
        if self.is_open {
            self.connections.note_failure(&mut self.timer);
            self.connection.close_on_drop();
        }
    }
}
