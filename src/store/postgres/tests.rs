//! What is true of a database that many share.

use std::time::Duration;

use futures_util::future::join_all;
use sqlx::SqlSafeStr;
use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::postgres::{PgConnectOptions, PgPool, PgPoolOptions};
use testkit::postgres::{Cluster, Database};
use testkit::proxy::Proxy;
use tokio::time::timeout;

use super::migrations::MIGRATIONS;
use super::*;
use crate::store::tests::{
    add_mesh, claim, exhausted, found, job, new_mesh, progress, receive, submit,
};
use crate::store::*;
use crate::wire::{JobId, JobState, Priority};

/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(60);

async fn open(url: &str) -> Postgres {
    Postgres::open(url, PoolSizes::of_server(4)).await.unwrap()
}

/// The tables, behind the back of the store.
fn beside(database: &Database) -> PgPool {
    let options: PgConnectOptions = database.url.parse().unwrap();
    PgPoolOptions::new().connect_lazy_with(options.options([("search_path", "graspd")]))
}

async fn execute(pool: &PgPool, statement: &'static str) {
    sqlx::query(statement).execute(pool).await.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn many_may_begin_at_the_same_moment() {
    let database = Cluster::shared().database();
    let stores = join_all((0..12).map(|_| open(&database.url))).await;
    let mesh = add_mesh(&stores[0], b"m").await;
    let id = submit(&stores[5], &mesh).await.id;
    assert_eq!(claim(&stores[11]).await.lease.job, id);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_lease_lasts_by_the_clock_of_the_database() {
    let database = Cluster::shared().database();
    let (store, beside) = (open(&database.url).await, beside(&database));
    let mesh = add_mesh(&store, b"m").await;
    let id = submit(&store, &mesh).await.id;
    let lease = claim(&store).await.lease;
    assert_eq!(store.recover(3, &exhausted()).await.unwrap(), []);
    let left = "SELECT leased_until - now_us() FROM jobs";
    let left: i64 = sqlx::query_scalar(left).fetch_one(&beside).await.unwrap();
    assert!((1..=10_000_000).contains(&left), "{left}");
    // Late, but before anyone else took it.
    execute(&beside, "UPDATE jobs SET leased_until = now_us() - 1").await;
    let standing = Renewal {
        lease: lease.clone(),
        revision: 3,
        progress: progress(),
    };
    let runs = [standing];
    assert_eq!(store.renew(&runs).await.unwrap(), [LeaseStatus::Held]);
    assert_eq!(store.recover(3, &exhausted()).await.unwrap(), []);

    execute(&beside, "UPDATE jobs SET leased_until = now_us() - 1").await;
    let taken = join_all((0..8).map(|_| async { store.recover(3, &exhausted()).await })).await;
    let taken: Vec<JobId> = taken.into_iter().flat_map(Result::unwrap).collect();
    assert_eq!(taken, [id], "by one of them");
    assert_eq!(store.renew(&runs).await.unwrap(), [LeaseStatus::Lost]);
    let late = store.finish(&lease, &found(), &progress(), 9).await;
    assert!(!late.unwrap());
    let record = job(&store, id).await;
    assert_eq!((record.state, record.attempt), (JobState::Queued, 2));
    assert!(record.result.is_none());
}

#[tokio::test(flavor = "multi_thread")]
async fn claims_at_the_same_moment_pass_each_other_over() {
    let database = Cluster::shared().database();
    let stores = join_all((0..4).map(|_| open(&database.url))).await;
    let mesh = add_mesh(&stores[0], b"m").await;
    for _ in 0..200 {
        submit(&stores[0], &mesh).await;
    }
    let claims = stores.iter().cycle().take(260);
    let claims = claims.map(|store| store.claim(Priority::Interactive));
    let claimed = join_all(claims).await;
    let mut claimed: Vec<JobId> = claimed
        .into_iter()
        .filter_map(|claim| Some(claim.unwrap()?.lease.job))
        .collect();
    claimed.sort();
    claimed.dedup();
    assert_eq!(claimed.len(), 200);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_only_a_later_program_can_read_is_left_to_it() {
    let database = Cluster::shared().database();
    let (store, beside) = (open(&database.url).await, beside(&database));
    let mesh = add_mesh(&store, b"m").await;
    submit(&store, &mesh).await;
    let plain = submit(&store, &mesh).await.id;
    execute(
        &beside,
        "UPDATE jobs SET format = 1000 WHERE id = (SELECT min(id) FROM jobs)",
    )
    .await;
    assert_eq!(claim(&store).await.lease.job, plain);
    assert!(store.claim(Priority::Interactive).await.unwrap().is_none());
}

#[tokio::test(flavor = "multi_thread")]
async fn tables_of_a_later_program_are_used_unless_they_forbid_it() {
    let database = Cluster::shared().database();
    let (store, beside) = (open(&database.url).await, beside(&database));
    let mesh = add_mesh(&store, b"m").await;
    // As a later one may leave them.
    for statement in [
        "ALTER TABLE jobs ADD COLUMN mood text NOT NULL DEFAULT 'good'",
        "ALTER TABLE meshes ADD COLUMN colour text",
        "CREATE TABLE moods (mood text)",
        "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time) \
         VALUES (1000, 'moods', true, '\\x00', 1)",
    ] {
        execute(&beside, statement).await;
    }
    // The one that runs goes on, and another one starts.
    for store in [&store, &open(&database.url).await] {
        let id = submit(store, &mesh).await.id;
        let lease = claim(store).await.lease;
        assert_eq!(lease.job, id);
        let finished = store.finish(&lease, &found(), &progress(), 2).await;
        assert!(finished.unwrap());
        assert!(job(store, id).await.result.is_some());
    }
    execute(&beside, "UPDATE compatibility SET oldest = 1000").await;
    let refused = Postgres::open(&database.url, PoolSizes::of_worker(1)).await;
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("use a later graspd"), "{refused}");
}

#[tokio::test(flavor = "multi_thread")]
async fn tables_that_others_hold_are_waited_for_in_steps_that_let_the_service_go_on() {
    let database = Cluster::shared().database();
    let (_, beside) = (open(&database.url).await, beside(&database));
    // As a later program has them.
    let moods = Migration::new(
        2,
        "moods".into(),
        MigrationType::Simple,
        "ALTER TABLE jobs ADD COLUMN mood text".into_sql_str(),
        false,
    );
    let later = Migrator {
        migrations: MIGRATIONS.iter().cloned().chain([moods]).collect(),
        ..Migrator::DEFAULT
    };
    // As a dump does, which goes on for long.
    let mut dump = beside.begin().await.unwrap();
    sqlx::query("SELECT count(*) FROM jobs")
        .execute(&mut *dump)
        .await
        .unwrap();
    let waits = "SELECT count(*) > 0 FROM pg_stat_activity \
                 WHERE datname = current_database() AND wait_event = 'relation'";
    let others = async {
        for held in [true, false, true] {
            let waits = async || {
                sqlx::query_scalar::<_, bool>(waits)
                    .fetch_one(&beside)
                    .await
            };
            let until = async {
                while waits().await.unwrap() != held {
                    tokio::time::sleep(Duration::from_millis(10)).await;
                }
            };
            let tried = timeout(PATIENCE, until).await;
            tried.expect("it tries, and tries again");
            // Behind one that waits for the tables others wait, too.
            let count = execute(&beside, "SELECT count(*) FROM jobs");
            let counted = timeout(PATIENCE, count).await;
            counted.expect("others have their turn");
        }
        dump.rollback().await.unwrap();
    };
    // The second one keeps out of the way meanwhile.
    let open = || Postgres::open_with(&database.url, PoolSizes::of_server(4), &later);
    let (store, second, ()) = tokio::join!(open(), open(), others);
    let (store, _) = (store.unwrap(), second.unwrap());
    let mesh = add_mesh(&store, b"m").await;
    submit(&store, &mesh).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn others_are_heard_and_oneself_is_not() {
    let database = Cluster::shared().database();
    let (one, other) = (open(&database.url).await, open(&database.url).await);
    let all = Audience {
        workers: true,
        servers: true,
    };
    let workers = Audience {
        workers: true,
        servers: false,
    };
    let mut line = one.listen(all).await.unwrap().unwrap();
    let mut worker = one.listen(workers).await.unwrap().unwrap();
    let many: Vec<JobId> = (0..1000).map(|_| JobId::new()).collect();
    let progress = Notice::Progress {
        job: many[0],
        revision: 7,
        progress: progress(),
    };
    one.notify(&[Notice::Queued]).await.unwrap();
    // Of a later program.
    let odd = "SELECT pg_notify('graspd_servers', '{\"from\":1,\"notices\":[{\"mood\":3},\"queued\"]}'), \
               pg_notify('graspd_servers', 'no message')";
    execute(&beside(&database), odd).await;
    other
        .notify(&[progress.clone(), Notice::Changed(many.clone())])
        .await
        .unwrap();
    other
        .notify(&[Notice::Stopped(many[..2].to_vec())])
        .await
        .unwrap();

    let mut heard = Vec::new();
    let mut changed = Vec::new();
    let hearing = async {
        while changed.len() < many.len() || heard.len() < 3 {
            for notice in line.receive().await.unwrap() {
                match notice {
                    Notice::Changed(jobs) => changed.extend(jobs),
                    notice => heard.push(notice),
                }
            }
        }
    };
    timeout(PATIENCE, hearing).await.expect("all is heard");
    assert_eq!(changed, many);
    let stopped = Notice::Stopped(many[..2].to_vec());
    assert_eq!(heard, [Notice::Queued, progress, stopped.clone()]);
    let received = timeout(PATIENCE, worker.receive()).await.unwrap();
    assert_eq!(received.unwrap(), [stopped]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_database_out_of_reach_is_given_up_and_found_again() {
    let cluster = Cluster::shared();
    let database = cluster.database();
    let proxy = Proxy::start(cluster.port());
    let store = open(&cluster.url_of(&database.name, proxy.port())).await;
    let mesh = add_mesh(&store, b"m").await;
    let id = submit(&store, &mesh).await.id;
    let line = store.listen(Audience {
        workers: true,
        servers: true,
    });
    let mut line = line.await.unwrap().unwrap();

    proxy.vanish();
    let dead = async {
        assert!(store.claim(Priority::Interactive).await.is_err());
        assert!(store.ping().await.is_err());
        assert!(store.renew(&[]).await.is_err());
        assert!(line.receive().await.is_err());
        let received = receive(&store, b"other").await;
        assert!(store.add_mesh(received, &new_mesh()).await.is_err());
    };
    timeout(PATIENCE, dead)
        .await
        .expect("nothing waits without end");
    proxy.appear();
    let back = async {
        while store.ping().await.is_err() {}
        loop {
            if let Ok(Some(claim)) = store.claim(Priority::Interactive).await {
                return claim;
            }
        }
    };
    let claim = timeout(PATIENCE, back).await.expect("it is found again");
    assert_eq!(claim.lease.job, id);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_acknowledged_is_synced_whatever_the_database_is_set_to() {
    let database = Cluster::shared().database();
    let beside = beside(&database);
    let lax = format!(
        "ALTER DATABASE {} SET synchronous_commit = off",
        database.name
    );
    sqlx::query(sqlx::AssertSqlSafe(lax))
        .execute(&beside)
        .await
        .unwrap();
    let store = open(&database.url).await;
    let setting = async || -> String {
        let shown = store
            .writes
            .run(sqlx::query("SHOW synchronous_commit"))
            .await;
        shown.unwrap().one::<(String,)>().unwrap().0
    };
    assert_eq!(setting().await, "on");
    // A claim alone need not be, and leaves no trace in its session.
    let mesh = add_mesh(&store, b"m").await;
    for _ in 0..10 {
        submit(&store, &mesh).await;
        claim(&store).await;
        assert_eq!(setting().await, "on");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_file_that_one_forgets_while_another_sends_it_is_there() {
    let database = Cluster::shared().database();
    let store = open(&database.url).await;
    let keep = Owner::of_key("keeps");
    let add = async |owner: &Owner| {
        let mesh = NewMesh {
            owner: owner.clone(),
            ..new_mesh()
        };
        let received = receive(&store, b"the same bytes").await;
        store.add_mesh(received, &mesh).await.unwrap().unwrap().0.id
    };
    for _ in 0..40 {
        let fleeting = Owner::of_key("forgets");
        let id = add(&fleeting).await;
        let (_, kept) = tokio::join!(store.delete_mesh(&fleeting, &id), add(&keep));
        let file = store.mesh_file(&keep, &kept).await.unwrap();
        assert!(file.is_some_and(|(_, bytes)| bytes == b"the same bytes"));
        assert_eq!(
            store.delete_mesh(&keep, &kept).await.unwrap(),
            Deletion::Done
        );
    }
    let files = store
        .reads
        .run(sqlx::query("SELECT count(*) FROM files"))
        .await;
    let (files,): (i64,) = files.unwrap().one().unwrap();
    assert_eq!(files, 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_address_that_means_something_else_is_refused_at_once() {
    let database = Cluster::shared().database();
    for (address, why) in [
        ("mysql://x/y".to_owned(), "mysql is no PostgreSQL"),
        ("nothing".to_owned(), "--store"),
        (
            format!("{}?sslmod=verify-full", database.url),
            "no setting sslmod",
        ),
        (format!("{}?sslmode=require", database.url), "TLS"),
        (database.url.replace("graspd:", "graspd:not"), "password"),
    ] {
        let refused = Postgres::open(&address, PoolSizes::of_worker(1)).await;
        let refused = refused.unwrap_err();
        assert!(!matches!(refused, OpenError::Silent(_)), "{address}");
        let message = refused.to_string();
        assert!(message.contains(why), "{message}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn who_may_not_make_a_schema_may_use_one_that_is_there() {
    let cluster = Cluster::shared();
    let database = cluster.database();
    let name = &database.name;
    cluster.ask(
        name,
        &format!(
            "CREATE ROLE poor_{name} LOGIN PASSWORD 'poor'; REVOKE CREATE ON DATABASE {name} FROM PUBLIC"
        ),
    );
    let poor = format!(
        "postgres://poor_{name}:poor@127.0.0.1:{}/{name}",
        cluster.port()
    );
    let refused = Postgres::open(&poor, PoolSizes::of_worker(1)).await;
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("right to create a schema"), "{refused}");
    cluster.ask(
        name,
        &format!("CREATE SCHEMA graspd AUTHORIZATION poor_{name}"),
    );
    for _ in 0..2 {
        open(&poor).await.ping().await.unwrap();
    }
}
