//! Whose turn it is holds for all workers together.

use serde_json::{Value, json};
use testkit::process::{ended, graspd};

use crate::fleet::{Fleet, PATIENCE};
use crate::history::steps;

/// Notes of each claim whether no other owner waited with fewer running jobs.
const WATCH: &str = "
    CREATE TABLE test_turns (fair boolean);
    CREATE FUNCTION test_running(whose text) RETURNS bigint LANGUAGE sql VOLATILE
        AS $$ SELECT count(*) FROM jobs WHERE state = 'running' AND owner = whose $$;
    CREATE FUNCTION test_turn() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
        INSERT INTO test_turns SELECT NOT EXISTS (
            SELECT FROM jobs WHERE state = 'queued' AND owner <> NEW.owner
            AND test_running(owner) < test_running(NEW.owner) - 1);
        RETURN NULL;
    END $$;
    CREATE TRIGGER test_turn AFTER UPDATE ON jobs FOR EACH ROW
        WHEN (OLD.state = 'queued' AND NEW.state = 'running') EXECUTE FUNCTION test_turn();
";

fn tiny(mesh: &str, seed: usize, priority: &str) -> Value {
    json!({
        "mesh_id": mesh, "seed": seed, "method": "random", "candidates": "triangles",
        "population": 50, "generations": 50, "priority": priority,
    })
}

/// Has two workers do all that waits; gives the jobs in the order in which they began.
async fn work_off(fleet: &mut Fleet, count: usize) -> Vec<String> {
    fleet.hire();
    fleet.hire();
    let end = std::time::Instant::now() + PATIENCE;
    loop {
        let steps = steps(&fleet.logs());
        let begun: Vec<String> = steps
            .into_iter()
            .filter(|step| step.begins)
            .map(|step| step.job)
            .collect();
        if begun.len() >= count {
            return begun;
        }
        assert!(std::time::Instant::now() < end, "{begun:?}");
        tokio::time::sleep(std::time::Duration::from_millis(50)).await;
    }
}

/// Places, counted from 1, of the jobs in the order in which all began.
fn places(order: &[String], jobs: &[String]) -> Vec<usize> {
    let place = |job| 1 + order.iter().position(|begun| begun == job).expect("begun");
    let mut places: Vec<usize> = jobs.iter().map(place).collect();
    places.sort();
    places
}

#[tokio::test(flavor = "multi_thread")]
async fn those_who_wait_for_their_jobs_come_first_at_every_worker() {
    let mut fleet = Fleet::start(2, &[]);
    let mesh = fleet.small_box(0).await;
    let mut jobs = [Vec::new(), Vec::new()];
    for (class, (priority, count)) in [("batch", 20), ("interactive", 6)].into_iter().enumerate() {
        for seed in 0..count {
            let job = fleet.job(seed % 2, &tiny(&mesh, seed, priority)).await;
            jobs[class].push(job);
        }
    }
    let order = work_off(&mut fleet, 26).await;
    let interactive = places(&order, &jobs[1]);
    // One claim in four of each worker prefers the others, so that 4 of any 10 may; and both workers log at almost
    // the same moment.
    assert!(interactive[5] <= 6 + 4 + 2, "{interactive:?} of 26");
    for job in jobs.iter().flatten() {
        fleet.wait_for(0, job, &["succeeded"]).await;
    }
    fleet.stop();
}

#[tokio::test(flavor = "multi_thread")]
async fn owners_take_turns_across_workers() {
    let mut fleet = Fleet::start(2, &["--auth", "keys"]);
    let mut owners = Vec::new();
    for (name, count) in [("many", 20), ("few", 5)] {
        let made = graspd(&["keys", "create", name])
            .env("GRASPD_STORE", &fleet.database.url)
            .output();
        let (key, _) = ended(&made.unwrap(), 0);
        fleet.key = Some(key.trim().to_owned());
        let mesh = fleet.small_box(0).await;
        let mut jobs = Vec::new();
        for seed in 0..count {
            let job = fleet.job(seed % 2, &tiny(&mesh, seed, "batch")).await;
            jobs.push(job);
        }
        owners.push(jobs);
    }
    fleet.ask(WATCH);
    let order = work_off(&mut fleet, 25).await;
    // In the order of arrival almost all of the first 20 claims would be unfair. One may be that was made at the same
    // moment as another.
    let unfair = fleet.ask("SELECT count(*) FROM test_turns WHERE NOT fair");
    let few = places(&order, &owners[1]);
    assert!(
        unfair.parse::<u32>().unwrap() <= 4,
        "{unfair}, {few:?} of 25"
    );
    assert_eq!(fleet.ask("SELECT count(*) >= 25 FROM test_turns"), "t");
    for job in &owners[1] {
        fleet.wait_for(1, job, &["succeeded"]).await;
    }
    fleet.stop();
}
