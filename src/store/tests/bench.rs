//! A store under test, and what a test has to do to it that no contract offers.

use std::ops::Deref;
use std::time::Duration;

use sqlx::AssertSqlSafe;
use sqlx::postgres::{PgConnectOptions, PgPool, PgPoolOptions};
use tempfile::TempDir;
use testkit::postgres::{Cluster, Database};

use super::super::postgres::{PoolSizes, Postgres};
use super::super::sqlite::{Sqlite, SqliteKeys};
use super::*;

/// A store, and where it is.
pub struct Bench {
    store: SharedStore,
    place: Place,
}

enum Place {
    Folder(TempDir),
    Database { data: Database, beside: PgPool },
}

impl Deref for Bench {
    type Target = dyn Store;

    fn deref(&self) -> &Self::Target {
        &*self.store
    }
}

impl Bench {
    /// An empty one in a folder.
    pub async fn folder() -> Self {
        let data = tempfile::tempdir().unwrap();
        Self {
            store: Arc::new(Sqlite::open(data.path()).await.unwrap()),
            place: Place::Folder(data),
        }
    }

    /// An empty one in a database.
    pub async fn database() -> Self {
        let data = Cluster::shared().database();
        let store = shared(&data.url).await;
        // Where its tables are.
        let options: PgConnectOptions = data.url.parse().unwrap();
        let options = options.options([("search_path", "graspd")]);
        let beside = PgPoolOptions::new().connect_lazy_with(options);
        Self {
            store,
            place: Place::Database { data, beside },
        }
    }

    /// The same store for another task.
    pub fn share(&self) -> SharedStore {
        Arc::clone(&self.store)
    }

    /// As after the death of its process.
    pub async fn reopen(self) -> Self {
        let Self { store, place } = self;
        drop(store);
        let store: SharedStore = match &place {
            Place::Folder(data) => Arc::new(Sqlite::open(data.path()).await.unwrap()),
            Place::Database { data, .. } => shared(&data.url).await,
        };
        Self { store, place }
    }

    /// Takes the jobs of holders that died, once their leases have run out. Says how many.
    pub async fn take_over(&self, max_attempts: u32) -> usize {
        if self.lease_time().is_some() {
            self.execute("UPDATE jobs SET leased_until = 0 WHERE state = 'running'")
                .await;
        }
        let taken = self.recover(max_attempts, &exhausted()).await.unwrap();
        taken.len()
    }

    /// Lets the leases of deliveries run out whose holder died.
    pub async fn take_over_webhooks(&self) {
        if self.lease_time().is_some() {
            self.execute("UPDATE webhooks SET leased_until = 0 WHERE lease IS NOT NULL")
                .await;
        }
    }

    /// Its keys, as the command line manages them beside it.
    pub async fn keys(&self) -> Box<dyn Keys> {
        match &self.place {
            Place::Folder(data) => Box::new(SqliteKeys::open(data.path()).await.unwrap()),
            Place::Database { data, .. } => Box::new(open(&data.url).await),
        }
    }

    /// Mesh files that are kept.
    pub async fn files(&self) -> usize {
        match &self.place {
            Place::Folder(data) => std::fs::read_dir(data.path().join("meshes"))
                .unwrap()
                .count(),
            Place::Database { .. } => self.rows("files").await as usize,
        }
    }

    /// Runs a statement behind the back of the store.
    pub async fn execute(&self, statement: &str) {
        self.try_execute(statement).await.unwrap();
    }

    /// As [`Bench::execute`], for one that may be refused.
    pub async fn try_execute(&self, statement: &str) -> Result<(), sqlx::Error> {
        let statement = AssertSqlSafe(statement.to_owned());
        match &self.place {
            Place::Folder(data) => {
                let mut connection = beside(data).await;
                sqlx::query(statement).execute(&mut connection).await?;
            }
            Place::Database { beside, .. } => {
                sqlx::query(statement).execute(beside).await?;
            }
        }
        Ok(())
    }

    /// The rows of a table.
    pub async fn rows(&self, table: &str) -> i64 {
        let count = AssertSqlSafe(format!("SELECT count(*) FROM {table}"));
        match &self.place {
            Place::Folder(data) => {
                let mut connection = beside(data).await;
                sqlx::query_scalar(count)
                    .fetch_one(&mut connection)
                    .await
                    .unwrap()
            }
            Place::Database { beside, .. } => {
                sqlx::query_scalar(count).fetch_one(beside).await.unwrap()
            }
        }
    }
}

async fn open(url: &str) -> Postgres {
    Postgres::open(url, PoolSizes::of_server(1)).await.unwrap()
}

async fn shared(url: &str) -> SharedStore {
    Arc::new(open(url).await)
}

/// Another connection to the database of a folder.
async fn beside(data: &TempDir) -> sqlx::SqliteConnection {
    use sqlx::ConnectOptions;
    sqlx::sqlite::SqliteConnectOptions::new()
        .filename(data.path().join("graspd.db"))
        .busy_timeout(Duration::from_secs(5))
        .connect()
        .await
        .unwrap()
}
