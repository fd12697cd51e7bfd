//! SIGKILL at random moments, some of them while the server starts.

use std::time::{Duration, Instant};

use crate::dice::Dice;
use crate::load::{Load, command, start};
use crate::{setting, verdict};

#[tokio::test(flavor = "multi_thread")]
async fn a_killed_server_loses_nothing_and_does_nothing_twice() {
    let kills = setting("GRASPD_KILLS", 8);
    let mut dice = Dice::thrown();
    let mut load = Load::prepare();
    let data = load.data();
    let mut server = start(command(), &data);
    load.serve_at(&server.url);
    load.start(&mut dice);
    let begun = Instant::now();
    for kill in 1..=kills {
        let life = Duration::from_millis(100 + dice.below(1400) as u64);
        tokio::time::sleep(life).await;
        server.signal("-KILL");
        if dice.below(4) == 0 {
            // It may die before it listens, too.
            let mut child = command()
                .args(["serve", "--listen", "127.0.0.1:0", "--data-dir"])
                .arg(&data)
                .stdout(std::process::Stdio::null())
                .spawn()
                .unwrap();
            tokio::time::sleep(Duration::from_millis(dice.below(60) as u64)).await;
            child.kill().unwrap();
            child.wait().unwrap();
        }
        server = start(command(), &data);
        load.serve_at(&server.url);
        if kill % 20 == 0 {
            println!("{kill} kills, {:?}", begun.elapsed());
        }
    }
    load.stop().await;
    let jobs = verdict::check_jobs(&load, 3).await;
    assert!(server.signal("-TERM").success());
    verdict::check_folder(&data).await;
    println!("{kills} kills in {:?}: {jobs}", begun.elapsed());
}
