//! On a database that others share.

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Executor};
use testkit::postgres::{Cluster, Database};

use super::*;

/// A server without workers, or a worker.
async fn member(database: &Database, data: &TempDir, role: Role) -> Service {
    start(Options {
        store: Location::Database(database.url.clone()),
        role,
        ..options_with_workers(data, usize::from(role == Role::Worker))
    })
    .await
}

async fn beside(database: &Database) -> PgConnection {
    let options: PgConnectOptions = database.url.parse().unwrap();
    let options = options.options([("search_path", "graspd")]);
    options.connect().await.unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_that_the_database_does_not_give_now_fails_no_job() {
    let (database, data) = (Cluster::shared().database(), data());
    let server = member(&database, &data, Role::Server).await;
    let job = submit(&server, "plain").await.id;
    let mut beside = beside(&database).await;
    beside
        .execute("BEGIN; LOCK TABLE pieces IN ACCESS EXCLUSIVE MODE")
        .await
        .unwrap();
    let worker = member(&database, &data, Role::Worker).await;
    let running = until(&server, job, JobState::Running).await;
    let clock = Instant::now();
    loop {
        let record = server.job(&Owner::ANONYMOUS, &job.to_string()).await;
        let record = record.unwrap();
        assert!(!record.state.is_final(), "{record:?}");
        // It was put back, and may have been taken again.
        if record.revision > running.revision {
            break;
        }
        assert!(clock.elapsed() < Duration::from_secs(40), "{record:?}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    beside.execute("ROLLBACK").await.unwrap();
    let ended = until(&server, job, JobState::Succeeded).await;
    assert_eq!(ended.attempt, 1);
    worker.shutdown().await;
}

/// A server and a worker on a database, the worker in a run without end, another job claimed ahead.
struct Held {
    server: Service,
    worker: Service,
    /// The other job, which soon is put back.
    ahead: JobId,
}

impl Held {
    async fn new(database: &Database, data: &TempDir) -> Self {
        let server = member(database, data, Role::Server).await;
        let mut jobs = Vec::new();
        // By the first ones a worker takes it that jobs are short.
        for label in std::iter::repeat_n("plain", 60).chain(["endless"; 2]) {
            jobs.push(submit(&server, label).await.id);
        }
        let worker = member(database, data, Role::Worker).await;
        let clock = Instant::now();
        let ahead = loop {
            let mut claimed = Vec::new();
            for job in &jobs {
                let record = server.job(&Owner::ANONYMOUS, &job.to_string()).await;
                let record = record.unwrap();
                if record.revision > 1 && !record.state.is_final() {
                    claimed.push(record);
                }
            }
            let runs = |record: &JobRecord| record.progress.is_some();
            if claimed.iter().any(runs)
                && let Some(other) = claimed.iter().find(|record| !runs(record))
            {
                break other.id;
            }
            assert!(clock.elapsed() < Duration::from_secs(20), "{claimed:?}");
        };
        Self {
            server,
            worker,
            ahead,
        }
    }

    async fn record(&self) -> JobRecord {
        let job = self.ahead.to_string();
        self.server.job(&Owner::ANONYMOUS, &job).await.unwrap()
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_claimed_ahead_is_put_back_when_no_worker_is_free_for_it() {
    let (database, data) = (Cluster::shared().database(), data());
    let held = Held::new(&database, &data).await;
    until(&held.server, held.ahead, JobState::Queued).await;
    let another = member(&database, &data, Role::Worker).await;
    let clock = Instant::now();
    let run = loop {
        let record = held.record().await;
        if record.progress.is_some() {
            break record;
        }
        assert!(clock.elapsed() < Duration::from_secs(20), "{record:?}");
    };
    assert_eq!(run.attempt, 1);
    another.shutdown().await;
    held.worker.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_worker_that_ends_leaves_no_job_claimed_ahead() {
    let (database, data) = (Cluster::shared().database(), data());
    let held = Held::new(&database, &data).await;
    held.worker.shutdown().await;
    let record = held.record().await;
    assert_eq!((record.state, record.attempt), (JobState::Queued, 1));
    assert!(record.started_at.is_none());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_cancelled_while_it_is_claimed_ahead_ends_without_a_run() {
    let (database, data) = (Cluster::shared().database(), data());
    let held = Held::new(&database, &data).await;
    let job = held.ahead.to_string();
    held.server.cancel(&Owner::ANONYMOUS, &job).await.unwrap();
    let ended = until(&held.server, held.ahead, JobState::Cancelled).await;
    assert!(ended.progress.is_none() && ended.result.is_none());
    held.worker.shutdown().await;
}
