//! Processes that share a database.

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

async fn connect(database: &Database) -> PgConnection {
    let options: PgConnectOptions = database.url.parse().unwrap();
    let options = options.options([("search_path", "graspd")]);
    options.connect().await.unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_that_the_database_does_not_deliver_now_fails_no_job() {
    let (database, data) = (Cluster::shared().database(), data());
    let server = member(&database, &data, Role::Server).await;
    let job = submit(&server, "plain").await.id;
    let mut connection = connect(&database).await;
    connection
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
    connection.execute("ROLLBACK").await.unwrap();
    let ended = until(&server, job, JobState::Succeeded).await;
    assert_eq!(ended.attempt, 1);
    worker.shutdown().await;
}

/// A server and a worker on a database; the worker is in a run without end and has prefetched another job.
struct Prefetched {
    server: Service,
    worker: Service,
    /// The prefetched job, which is soon put back.
    job: JobId,
}

impl Prefetched {
    async fn new(database: &Database, data: &TempDir) -> Self {
        let server = member(database, data, Role::Server).await;
        let mut jobs = Vec::new();
        // The first ones teach the worker that jobs are short.
        for label in std::iter::repeat_n("plain", 60).chain(["endless"; 2]) {
            jobs.push(submit(&server, label).await.id);
        }
        let worker = member(database, data, Role::Worker).await;
        let clock = Instant::now();
        let job = loop {
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
            job,
        }
    }

    async fn record(&self) -> JobRecord {
        let job = self.job.to_string();
        self.server.job(&Owner::ANONYMOUS, &job).await.unwrap()
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_prefetched_job_is_put_back_when_no_worker_is_free_for_it() {
    let (database, data) = (Cluster::shared().database(), data());
    let members = Prefetched::new(&database, &data).await;
    until(&members.server, members.job, JobState::Queued).await;
    let another = member(&database, &data, Role::Worker).await;
    let clock = Instant::now();
    let run = loop {
        let record = members.record().await;
        if record.progress.is_some() {
            break record;
        }
        assert!(clock.elapsed() < Duration::from_secs(20), "{record:?}");
    };
    assert_eq!(run.attempt, 1);
    another.shutdown().await;
    members.worker.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_worker_that_ends_leaves_no_prefetched_job() {
    let (database, data) = (Cluster::shared().database(), data());
    let members = Prefetched::new(&database, &data).await;
    members.worker.shutdown().await;
    let record = members.record().await;
    assert_eq!((record.state, record.attempt), (JobState::Queued, 1));
    assert!(record.started_at.is_none());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_cancelled_while_it_is_prefetched_ends_without_a_run() {
    let (database, data) = (Cluster::shared().database(), data());
    let members = Prefetched::new(&database, &data).await;
    let job = members.job.to_string();
    members
        .server
        .cancel(&Owner::ANONYMOUS, &job)
        .await
        .unwrap();
    let ended = until(&members.server, members.job, JobState::Cancelled).await;
    assert!(ended.progress.is_none() && ended.result.is_none());
    members.worker.shutdown().await;
}
