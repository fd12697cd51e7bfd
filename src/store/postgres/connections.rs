//! Connections whose statements are timed, counted, and not waited for without end.

use std::io;
use std::ops::{Deref, DerefMut};
use std::time::{Duration, Instant};

use futures_util::future::BoxFuture;
use futures_util::stream::{self, BoxStream, StreamExt};
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::histogram::Histogram;
use sqlx::pool::PoolConnection;
use sqlx::postgres::{PgConnection, PgPool, PgQueryResult, PgRow, PgTypeInfo};
use sqlx::{Either, Execute, Executor, SqlStr};
use tokio::time::timeout;

use crate::metrics::{Operation, StoreMetrics};
use crate::store::StoreError;

/// Longest that one statement is waited for, the wait for a connection included.
pub const PATIENCE: Duration = Duration::from_secs(8);

type Database = sqlx::Postgres;
type Steps = Vec<Result<Either<PgQueryResult, PgRow>, sqlx::Error>>;

/// A pool of connections whose statements are timed, counted, and given up when the database does not answer.
/// Clones share connections.
#[derive(Debug, Clone)]
pub struct Connections {
    pool: PgPool,
    patience: Duration,
    seconds: Histogram,
    errors: Counter,
}

impl Connections {
    pub fn new(pool: PgPool, metrics: &StoreMetrics, operation: Operation) -> Self {
        Self {
            pool,
            patience: PATIENCE,
            seconds: metrics.seconds(operation),
            errors: metrics.errors(operation),
        }
    }

    /// The same, whose statements are given up sooner.
    pub fn hasty(self, patience: Duration) -> Self {
        Self { patience, ..self }
    }

    /// Begins a transaction; timed until it ends. Only its begin is given up when the database does not answer: what
    /// is done in it, [`within`] bounds.
    pub async fn begin(&self) -> Result<Transaction, sqlx::Error> {
        let timer = Timer::start(self);
        let mut connection = self.acquire().await?;
        connection.run(self.patience, sqlx::query("BEGIN")).await?;
        connection.busy = true;
        Ok(Transaction { connection, timer })
    }

    pub async fn close(&self) {
        self.pool.close().await;
    }

    async fn acquire(&self) -> Result<Held, sqlx::Error> {
        let connection = timeout(self.patience, self.pool.acquire());
        let connection = connection.await.map_err(|_| too_slow())??;
        Ok(Held {
            connection: Some(connection),
            busy: false,
        })
    }

    async fn all<'q, E: 'q + Execute<'q, Database>>(&self, query: E) -> Result<Steps, sqlx::Error> {
        let mut timer = Timer::start(self);
        let steps = self.acquire().await?.run(self.patience, query).await?;
        timer.failed = false;
        Ok(steps)
    }
}

impl<'p> Executor<'p> for &Connections {
    type Database = Database;

    /// All rows at once: no statement here returns more than a page of them.
    fn fetch_many<'e, 'q: 'e, E>(
        self,
        query: E,
    ) -> BoxStream<'e, Result<Either<PgQueryResult, PgRow>, sqlx::Error>>
    where
        'p: 'e,
        E: 'q + Execute<'q, Database>,
    {
        let connections = self.clone();
        stream::once(async move {
            match connections.all(query).await {
                Ok(steps) => stream::iter(steps),
                Err(error) => stream::iter(vec![Err(error)]),
            }
        })
        .flatten()
        .boxed()
    }

    fn fetch_optional<'e, 'q: 'e, E>(
        self,
        query: E,
    ) -> BoxFuture<'e, Result<Option<PgRow>, sqlx::Error>>
    where
        'p: 'e,
        E: 'q + Execute<'q, Database>,
    {
        let connections = self.clone();
        Box::pin(async move {
            let steps = connections.all(query).await?;
            steps
                .into_iter()
                .find_map(|step| step.map(Either::right).transpose())
                .transpose()
        })
    }

    fn prepare_with<'e>(
        self,
        sql: SqlStr,
        parameters: &'e [PgTypeInfo],
    ) -> BoxFuture<'e, Result<<Database as sqlx::Database>::Statement, sqlx::Error>>
    where
        'p: 'e,
    {
        (&self.pool).prepare_with(sql, parameters)
    }

    fn describe<'e>(
        self,
        sql: SqlStr,
    ) -> BoxFuture<'e, Result<sqlx::Describe<Database>, sqlx::Error>>
    where
        'p: 'e,
    {
        (&self.pool).describe(sql)
    }
}

/// A connection that goes back to its pool only between statements: one that was left in the midst of one, by a
/// caller who lost interest or by a database that did not answer, is closed, so that nobody waits for it again.
#[derive(Debug)]
struct Held {
    /// There until it is dropped.
    connection: Option<PoolConnection<Database>>,
    busy: bool,
}

impl Held {
    fn get(&self) -> &PgConnection {
        self.connection.as_ref().expect("held until it is dropped")
    }

    fn get_mut(&mut self) -> &mut PgConnection {
        self.connection.as_mut().expect("held until it is dropped")
    }

    async fn run<'q, E: 'q + Execute<'q, Database>>(
        &mut self,
        patience: Duration,
        query: E,
    ) -> Result<Steps, sqlx::Error> {
        self.busy = true;
        let connection = self.get_mut();
        let steps = timeout(patience, async {
            let mut steps = Vec::new();
            let mut stream = connection.fetch_many(query);
            while let Some(step) = stream.next().await {
                steps.push(Ok(step?));
            }
            Ok::<Steps, sqlx::Error>(steps)
        });
        match steps.await {
            Ok(steps) => {
                // After an error of the connection, it is none.
                self.busy = matches!(&steps, Err(error) if error.as_database_error().is_none());
                steps
            }
            Err(_) => Err(too_slow()),
        }
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        if let Some(connection) = self.connection.take()
            && self.busy
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
    /// Keeps what was written.
    pub async fn commit(mut self) -> Result<(), sqlx::Error> {
        self.end("COMMIT").await
    }

    /// Takes back what was written.
    pub async fn rollback(mut self) -> Result<(), sqlx::Error> {
        self.end("ROLLBACK").await
    }

    async fn end(&mut self, statement: &'static str) -> Result<(), sqlx::Error> {
        sqlx::query(statement).execute(&mut **self).await?;
        self.connection.busy = false;
        self.timer.failed = false;
        Ok(())
    }
}

impl Deref for Transaction {
    type Target = PgConnection;

    fn deref(&self) -> &PgConnection {
        self.connection.get()
    }
}

impl DerefMut for Transaction {
    fn deref_mut(&mut self) -> &mut PgConnection {
        self.connection.get_mut()
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

/// Times one statement or transaction for as long as it lives.
#[derive(Debug)]
struct Timer {
    started: Instant,
    /// Until it has succeeded.
    failed: bool,
    seconds: Histogram,
    errors: Counter,
}

impl Timer {
    fn start(connections: &Connections) -> Self {
        Self {
            started: Instant::now(),
            failed: true,
            seconds: connections.seconds.clone(),
            errors: connections.errors.clone(),
        }
    }
}

impl Drop for Timer {
    fn drop(&mut self) {
        self.seconds.observe(self.started.elapsed().as_secs_f64());
        if self.failed {
            self.errors.inc();
        }
    }
}
