//! On a database that others share.

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Executor};

use super::*;
use crate::store::tests::cluster::{Cluster, Database};

/// A server without workers, or a worker.
async fn member(database: &Database, data: &TempDir, role: Role) -> Service {
    start(Options {
        store: Location::Database(database.url.clone()),
        role,
        workers: usize::from(role == Role::Worker),
        ..options(data)
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
