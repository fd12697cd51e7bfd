//! SIGTERM, SIGSTOP and SIGCONT under load: no attempt is used up.

use std::time::{Duration, Instant};

use testkit::environment::number;
use testkit::load::random::SplitMix64;
use testkit::load::verdict;
use testkit::load::{Habits, Load};

use crate::server::{command, start};

#[tokio::test(flavor = "multi_thread")]
async fn an_orderly_end_under_load_is_quick_and_costs_no_attempt() {
    let ends = number("GRASPD_TERMS", 3);
    let mut random = SplitMix64::seeded();
    let mut load = Load::prepare(&Habits::default());
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let mut server = start(command(), &data);
    load.serve_at(&[&server.url]);
    load.start(&mut random);
    let mut took = Vec::new();
    for _ in 0..ends {
        let life = Duration::from_millis(200 + random.below(800) as u64);
        tokio::time::sleep(life).await;
        let begun = Instant::now();
        let status = tokio::task::spawn_blocking(move || server.signal("-TERM")).await;
        assert!(status.unwrap().success());
        took.push(begun.elapsed());
        server = start(command(), &data);
        load.serve_at(&[&server.url]);
    }
    load.stop().await;
    let jobs = verdict::check_jobs(&load, 1).await;
    assert!(server.signal("-TERM").success());
    crate::folder::check(&data).await;
    took.sort();
    let longest = took[took.len() - 1];
    assert!(longest < Duration::from_secs(25), "{took:?}");
    println!(
        "{ends} ends, {jobs}: median {:?}, longest {longest:?}",
        took[took.len() / 2]
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_that_was_frozen_goes_on_where_it_was() {
    let mut random = SplitMix64::seeded();
    let mut load = Load::prepare(&Habits::default());
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let mut server = start(command(), &data);
    load.serve_at(&[&server.url]);
    load.start(&mut random);
    for _ in 0..2 {
        tokio::time::sleep(Duration::from_millis(700)).await;
        server.send("-STOP");
        tokio::time::sleep(Duration::from_secs(3)).await;
        server.send("-CONT");
    }
    tokio::time::sleep(Duration::from_millis(500)).await;
    load.stop().await;
    verdict::check_jobs(&load, 1).await;
    assert!(server.signal("-TERM").success());
    crate::folder::check(&data).await;
}
