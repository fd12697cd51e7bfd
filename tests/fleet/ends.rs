//! Every member ended in order and started again, one after the other, while the others work.

use std::time::Duration;

use testkit::load::random::SplitMix64;
use testkit::load::verdict;
use testkit::load::{Habits, Load};

use crate::fleet::Fleet;

fn announce(fleet: &Fleet, load: &Load) {
    let urls: Vec<&str> = fleet
        .servers
        .iter()
        .map(|server| server.url.as_str())
        .collect();
    load.serve_at(&urls);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_rolling_restart_under_load_costs_no_attempt() {
    let mut random = SplitMix64::seeded();
    let mut load = Load::prepare(&Habits {
        size: 30,
        pause: Duration::from_millis(500),
        patience: Duration::from_secs(20),
    });
    let mut fleet = Fleet::start(2, &[]);
    for _ in 0..3 {
        fleet.hire();
    }
    announce(&fleet, &load);
    load.start(&mut random);
    for number in 0..5 {
        tokio::time::sleep(Duration::from_millis(500)).await;
        let (servers, workers) = (&mut fleet.servers, &mut fleet.workers);
        let member = servers.iter_mut().chain(workers).nth(number).unwrap();
        // The clients go on meanwhile.
        let status = tokio::task::block_in_place(|| {
            let status = member.end("-TERM");
            member.start();
            status
        });
        assert!(status.success(), "{:?}: {status}", member.role);
        announce(&fleet, &load);
    }
    tokio::time::sleep(Duration::from_millis(500)).await;
    load.stop().await;
    println!("{}", verdict::check_jobs(&load, 1).await);
    fleet.stop();
}
