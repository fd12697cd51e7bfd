//! A worker that loses its lease: frozen past its end, or cut off from the database.

use std::time::Duration;

use reqwest::Method;
use serde_json::{Value, json};
use testkit::postgres::Cluster;
use testkit::proxy::Proxy;
use tokio::time::sleep;

use crate::fleet::{Fleet, until};
use crate::history::{Step, steps};

/// Processor time, in ticks of a hundredth of a second, after which a search is seen to go on; and most that a
/// process takes in a second when there is none.
const BUSY: u64 = 50;
const IDLE: u64 = 10;

/// Notes every change of a job or of a result from now on.
const WATCH: &str = "
    CREATE TABLE test_writes (what text);
    CREATE FUNCTION test_note() RETURNS trigger LANGUAGE plpgsql
        AS $$ BEGIN INSERT INTO test_writes VALUES (TG_OP || ' ' || TG_TABLE_NAME); RETURN NULL; END $$;
    CREATE TRIGGER test_jobs AFTER INSERT OR UPDATE OR DELETE ON jobs
        FOR EACH ROW EXECUTE FUNCTION test_note();
    CREATE TRIGGER test_results AFTER INSERT OR UPDATE OR DELETE ON results
        FOR EACH ROW EXECUTE FUNCTION test_note();
";

/// A search that goes on for so many seconds.
fn long(mesh: &str, seconds: u32) -> Value {
    json!({
        "mesh_id": mesh, "seed": 7, "method": "random", "candidates": "triangles",
        "population": 10_000, "generations": 90_000, "time_limit_s": seconds,
    })
}

/// Whether a worker has taken a job up, or left it.
fn has(fleet: &Fleet, worker: usize, job: &str, begun: bool) -> bool {
    let is_it = |step: &Step| step.worker == worker && step.job == job && step.begins == begun;
    steps(&fleet.logs()).iter().any(is_it)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_worker_that_wakes_past_its_lease_writes_nothing() {
    let mut fleet = Fleet::start(1, &[]);
    let mesh = fleet.small_box(0).await;
    fleet.hire();
    let job = fleet.job(0, &long(&mesh, 3)).await;
    until("the job begins", || has(&fleet, 0, &job, true)).await;
    fleet.workers[0].send("-STOP");
    fleet.hire();
    let ended = fleet.wait_for(0, &job, &["succeeded", "failed"]).await;
    assert_eq!(ended["state"], "succeeded", "{ended}");
    assert_eq!(ended["attempt"], 2, "{ended}");
    assert!(has(&fleet, 1, &job, false));

    fleet.ask(WATCH);
    fleet.workers[0].send("-CONT");
    // Its time is over, so it has a result at once.
    until("the first worker leaves the job", || {
        has(&fleet, 0, &job, false)
    })
    .await;
    assert_eq!(fleet.ask("SELECT DISTINCT what FROM test_writes"), "");
    assert_eq!(fleet.view(0, &job).await, ended);

    // It is as good as new.
    assert!(fleet.workers[1].end("-TERM").success());
    let next = fleet.job(0, &long(&mesh, 1)).await;
    assert_eq!(fleet.wait_for(0, &next, &["succeeded"]).await["attempt"], 1);
    assert!(has(&fleet, 0, &next, true));
    assert_ne!(fleet.ask("SELECT DISTINCT what FROM test_writes"), "");
    fleet.workers.truncate(1);
    fleet.stop();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_worker_that_is_cut_off_stops_before_another_begins_and_comes_back() {
    let mut fleet = Fleet::start(1, &[]);
    let mesh = fleet.small_box(0).await;
    let proxy = Proxy::start(Cluster::shared().port());
    let through = Cluster::shared().url_of(&fleet.database.name, proxy.port());
    fleet.hire_at(&through);
    let job = fleet.job(0, &long(&mesh, 600)).await;
    let first = fleet.workers[0].ticks();
    until("the search goes on", || {
        fleet.workers[0].ticks() > first + BUSY
    })
    .await;
    proxy.vanish();
    fleet.hire();
    until("the job begins elsewhere", || has(&fleet, 1, &job, true)).await;
    let before = fleet.workers[0].ticks();
    sleep(Duration::from_secs(1)).await;
    let spent = fleet.workers[0].ticks() - before;
    assert!(spent <= IDLE, "it still works: {spent} ticks in a second");
    assert_eq!(fleet.view(0, &job).await["attempt"], 2);

    proxy.appear();
    // The second worker is busy: the first one takes what comes next.
    let next = fleet.job(0, &long(&mesh, 1)).await;
    fleet.wait_for(0, &next, &["succeeded"]).await;
    assert!(has(&fleet, 0, &next, true));
    let cancel = fleet.request(0, Method::POST, &format!("/jobs/{job}/cancel"));
    assert_eq!(fleet.answer(cancel).await.0, 202);
    let ended = fleet.wait_for(0, &job, &["cancelled"]).await;
    assert_eq!(ended["attempt"], 2, "{ended}");
    fleet.stop();
}
