//! Connections whose statements are timed and counted.

use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use futures_util::future::BoxFuture;
use futures_util::stream::{self, BoxStream, StreamExt};
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::histogram::Histogram;
use sqlx::pool::PoolConnection;
use sqlx::sqlite::{SqliteConnection, SqlitePool, SqliteQueryResult, SqliteRow, SqliteTypeInfo};
use sqlx::{Either, Execute, Executor, SqlStr, Sqlite};

use crate::metrics::{Operation, StoreMetrics};

/// A pool of connections that times every statement it is given, and remembers when the last one
/// succeeded. Clones share connections and memory.
#[derive(Debug, Clone)]
pub struct Metered {
    pool: SqlitePool,
    seconds: Histogram,
    errors: Counter,
    /// When something was last written; `None` when a statement has failed since.
    written: Arc<Mutex<Option<Instant>>>,
}

impl Metered {
    pub fn new(pool: SqlitePool, metrics: &StoreMetrics, operation: Operation) -> Self {
        Self {
            pool,
            seconds: metrics.seconds(operation),
            errors: metrics.errors(operation),
            written: Arc::default(),
        }
    }

    /// When something was last written; `None` when a statement has failed since.
    pub fn written(&self) -> Option<Instant> {
        *self.memory()
    }

    /// Takes note of a write that changed no row.
    pub fn note_written(&self) {
        *self.memory() = Some(Instant::now());
    }

    /// Begins a transaction that writes; timed until it ends.
    pub async fn begin(&self) -> Result<MeteredTransaction, sqlx::Error> {
        let mut timer = self.start();
        let begun: Result<_, sqlx::Error> = async {
            let mut connection = self.pool.acquire().await?;
            sqlx::query("BEGIN IMMEDIATE")
                .execute(&mut *connection)
                .await?;
            Ok(connection)
        }
        .await;
        if begun.is_err() {
            timer.note(false);
        }
        Ok(MeteredTransaction {
            connection: begun?,
            open: true,
            timer,
        })
    }

    fn start(&self) -> Timer {
        Timer {
            started: Instant::now(),
            outcome: None,
            wrote: false,
            metered: self.clone(),
        }
    }

    fn memory(&self) -> MutexGuard<'_, Option<Instant>> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// For what is asked of a pool beside statements.
impl Deref for Metered {
    type Target = SqlitePool;

    fn deref(&self) -> &SqlitePool {
        &self.pool
    }
}

impl<'p> Executor<'p> for &Metered {
    type Database = Sqlite;

    fn fetch_many<'e, 'q: 'e, E>(
        self,
        query: E,
    ) -> BoxStream<'e, Result<Either<SqliteQueryResult, SqliteRow>, sqlx::Error>>
    where
        'p: 'e,
        E: 'q + Execute<'q, Sqlite>,
    {
        let steps = (&self.pool).fetch_many(query);
        stream::unfold((steps, self.start()), |(mut steps, mut timer)| async move {
            let step = steps.next().await;
            match &step {
                // A statement that finds nothing to change succeeds on a full disk too.
                Some(Ok(Either::Left(done))) => timer.wrote |= done.rows_affected() > 0,
                Some(Ok(Either::Right(_))) => timer.wrote = true,
                Some(Err(_)) => timer.note(false),
                None => timer.note(true),
            }
            step.map(|step| (step, (steps, timer)))
        })
        .boxed()
    }

    fn fetch_optional<'e, 'q: 'e, E>(
        self,
        query: E,
    ) -> BoxFuture<'e, Result<Option<SqliteRow>, sqlx::Error>>
    where
        'p: 'e,
        E: 'q + Execute<'q, Sqlite>,
    {
        let row = (&self.pool).fetch_optional(query);
        let mut timer = self.start();
        Box::pin(async move {
            let row = row.await;
            timer.note(row.is_ok());
            row
        })
    }

    fn prepare_with<'e>(
        self,
        sql: SqlStr,
        parameters: &'e [SqliteTypeInfo],
    ) -> BoxFuture<'e, Result<<Sqlite as sqlx::Database>::Statement, sqlx::Error>>
    where
        'p: 'e,
    {
        (&self.pool).prepare_with(sql, parameters)
    }

    fn describe<'e>(self, sql: SqlStr) -> BoxFuture<'e, Result<sqlx::Describe<Sqlite>, sqlx::Error>>
    where
        'p: 'e,
    {
        (&self.pool).describe(sql)
    }
}

/// A transaction that is timed from its begin to its end.
///
/// SQLite ends a transaction by itself where a write fails, as on a full disk, and not everywhere: nobody
/// can tell whether there is one to roll back. So the connection of one that was not brought to its end is
/// closed, which is right either way, and another takes its place.
#[derive(Debug)]
pub struct MeteredTransaction {
    connection: PoolConnection<Sqlite>,
    open: bool,
    timer: Timer,
}

impl MeteredTransaction {
    /// Keeps what was written.
    pub async fn commit(mut self) -> Result<(), sqlx::Error> {
        let outcome = self.end("COMMIT").await;
        self.timer.wrote = true;
        self.timer.note(outcome.is_ok());
        outcome
    }

    /// Takes back what was written.
    pub async fn rollback(mut self) -> Result<(), sqlx::Error> {
        self.end("ROLLBACK").await
    }

    async fn end(&mut self, statement: &'static str) -> Result<(), sqlx::Error> {
        sqlx::query(statement)
            .execute(&mut *self.connection)
            .await?;
        self.open = false;
        Ok(())
    }
}

impl Drop for MeteredTransaction {
    fn drop(&mut self) {
        if self.open {
            self.timer.note(false);
            self.connection.close_on_drop();
        }
    }
}

impl Deref for MeteredTransaction {
    type Target = SqliteConnection;

    fn deref(&self) -> &SqliteConnection {
        &self.connection
    }
}

impl DerefMut for MeteredTransaction {
    fn deref_mut(&mut self) -> &mut SqliteConnection {
        &mut self.connection
    }
}

/// Times one statement or transaction for as long as it lives.
#[derive(Debug)]
struct Timer {
    started: Instant,
    /// `None` until it has ended; what was given up half-way says nothing about the store.
    outcome: Option<bool>,
    /// Whether anything was written, should it succeed.
    wrote: bool,
    metered: Metered,
}

impl Timer {
    fn note(&mut self, succeeded: bool) {
        self.outcome = Some(succeeded);
    }
}

impl Drop for Timer {
    fn drop(&mut self) {
        let metered = &self.metered;
        metered
            .seconds
            .observe(self.started.elapsed().as_secs_f64());
        match self.outcome {
            Some(true) if self.wrote => metered.note_written(),
            Some(false) => {
                metered.errors.inc();
                *metered.memory() = None;
            }
            Some(true) | None => {}
        }
    }
}
