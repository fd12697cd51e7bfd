//! SIGKILL at random moments, some of them while the server starts.

use std::time::{Duration, Instant};

use reqwest::Method;
use serde_json::Value;
use testkit::environment::number;
use testkit::load::client::Body;
use testkit::load::random::SplitMix64;
use testkit::load::verdict;
use testkit::load::{Habits, Load};

use crate::promised;
use crate::server::{command, start};

#[tokio::test(flavor = "multi_thread")]
async fn a_killed_server_loses_nothing_and_does_nothing_twice() {
    let kills = number("GRASPD_KILLS", 8);
    let mut random = SplitMix64::seeded();
    let mut load = Load::prepare(&Habits::default());
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let mut server = start(command(), &data);
    load.serve_at(&[&server.url]);
    load.start(&mut random);
    let begun = Instant::now();
    let mut resumed = Vec::new();
    for kill in 1..=kills {
        let life = Duration::from_millis(100 + random.below(1400) as u64);
        tokio::time::sleep(life).await;
        let interrupted = running(&load).await;
        server.signal("-KILL");
        if random.below(4) == 0 {
            // It may die before it listens, too.
            let mut child = command()
                .args(["serve", "--listen", "127.0.0.1:0", "--data-dir"])
                .arg(&data)
                .stdout(std::process::Stdio::null())
                .spawn()
                .unwrap();
            tokio::time::sleep(Duration::from_millis(random.below(60) as u64)).await;
            child.kill().unwrap();
            child.wait().unwrap();
        }
        let restarted = Instant::now();
        server = start(command(), &data);
        load.serve_at(&[&server.url]);
        if runs_again(&load, interrupted, restarted).await {
            resumed.push(restarted.elapsed());
        }
        if kill % 20 == 0 {
            println!("{kill} kills, {:?}", begun.elapsed());
        }
    }
    load.stop().await;
    let jobs = verdict::check_jobs(&load, 3).await;
    assert!(server.signal("-TERM").success());
    crate::folder::check(&data).await;
    println!("{kills} kills in {:?}: {jobs}", begun.elapsed());
    resumed.sort();
    // A few kills may all come between two runs.
    assert!(!resumed.is_empty() || kills < 50);
    let Some(longest) = resumed.last() else {
        return;
    };
    println!(
        "from a restart to the first interrupted job running again, {} times: median {:?}, longest {longest:?}",
        resumed.len(),
        resumed[resumed.len() / 2]
    );
    assert!(*longest < promised(2), "{resumed:?}");
}

/// The jobs that run, with the attempt of each.
async fn running(load: &Load) -> Vec<(String, u64)> {
    let path = "/jobs?state=running";
    let answer = load.caller.call(Method::GET, path, &Body::Nothing).await;
    let answer = answer.unwrap();
    assert_eq!(answer.status, 200, "{}", answer.body);
    let jobs = answer.body["jobs"].as_array().into_iter().flatten();
    let id = |job: &Value| job["id"].as_str().unwrap().to_owned();
    jobs.map(|job| (id(job), job["attempt"].as_u64().unwrap()))
        .collect()
}

/// Waits until one of the jobs runs at a later attempt, or has. Says no when none of them will: they had ended
/// before the server did, or were cancelled or deleted.
async fn runs_again(load: &Load, mut jobs: Vec<(String, u64)>, since: Instant) -> bool {
    while !jobs.is_empty() {
        let mut left = Vec::new();
        for (id, attempt) in jobs {
            let path = format!("/jobs/{id}");
            let answer = load.caller.call(Method::GET, &path, &Body::Nothing).await;
            let view = answer.unwrap().body;
            let is_later = view["attempt"].as_u64().is_some_and(|now| now > attempt);
            match view["state"].as_str() {
                Some("queued") => left.push((id, attempt)),
                Some(_) if is_later => return true,
                _ => {}
            }
        }
        jobs = left;
        assert!(since.elapsed() < promised(10), "still queued: {jobs:?}");
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    false
}
