//! The clock of the machine set an hour forward, then an hour back, while jobs wait or run.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use jiff::{SignedDuration, Timestamp};
use reqwest::Method;
use serde_json::{Value, json};
use testkit::install::install;
use testkit::load::client::Body;
use testkit::load::ledger::lives;
use testkit::load::{Habits, Load};

use crate::server::{command, start};

/// Longest that a job is waited for.
const PATIENCE: Duration = Duration::from_secs(120);

/// The library that shifts the clock of a process; installed when it is missing, once for all tests.
fn faketime() -> &'static Path {
    static LIBRARY: LazyLock<PathBuf> = LazyLock::new(|| {
        let found = || {
            let folders = std::fs::read_dir("/usr/lib").into_iter().flatten();
            folders
                .filter_map(|entry| Some(entry.ok()?.path().join("faketime/libfaketime.so.1")))
                .find(|path| path.exists())
        };
        found().unwrap_or_else(|| {
            install("faketime");
            found().expect("libfaketime")
        })
    });
    &LIBRARY
}

async fn upload(load: &Load) -> String {
    let body = Body::Mesh(&load.orders[0].mesh);
    let answer = load.caller.call(Method::POST, "/meshes", &body).await;
    answer.unwrap().body["id"].as_str().unwrap().to_owned()
}

fn shifted(by: &str) -> Command {
    let mut command = command();
    command.env("LD_PRELOAD", faketime()).env("FAKETIME", by);
    command
}

async fn submit(load: &Load, mesh: &str, seed: usize, size: usize) -> Value {
    let request = json!({
        "mesh_id": mesh, "seed": seed, "candidates": "triangles", "method": "random",
        "population": size, "generations": size,
    });
    let body = Body::Json(&request, None);
    let answer = load.caller.call(Method::POST, "/jobs", &body).await;
    let answer = answer.unwrap();
    assert_eq!(answer.status, 202, "{}", answer.body);
    answer.body
}

/// Waits for the end of a job, whose times must be in order.
async fn ends_well(load: &Load, id: &str) {
    let path = format!("/jobs/{id}");
    let end = Instant::now() + PATIENCE;
    let view = loop {
        let answer = load.caller.call(Method::GET, &path, &Body::Nothing).await;
        let view = answer.unwrap().body;
        if !lives(&view) {
            break view;
        }
        assert!(Instant::now() < end, "never ends: {view}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    };
    assert_eq!(view["state"], "succeeded", "{view}");
    let times = ["created_at", "started_at", "finished_at"].map(|name| time(&view, name));
    assert!(times.is_sorted(), "{view}");
    assert!(view["result"]["elapsed_s"].as_f64().unwrap() >= 0.0);
}

fn time(view: &Value, name: &str) -> Timestamp {
    view[name].as_str().unwrap().parse().unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_clock_that_jumps_between_two_lives_breaks_nothing() {
    faketime();
    let load = Load::prepare(&Habits::default());
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let mut ids = Vec::new();
    let mut mesh = String::new();
    for shift in ["+1h", "-1h", "+0"] {
        let mut server = start(shifted(shift), &data);
        load.serve_at(&[&server.url]);
        if mesh.is_empty() {
            mesh = upload(&load).await;
        }
        // The first two keep the workers busy, so that the rest waits for the next clock.
        for number in 0..8 {
            let size = if number < 2 { 300 } else { 5 };
            let job = submit(&load, &mesh, number, size).await;
            ids.push(job["id"].as_str().unwrap().to_owned());
        }
        assert!(server.signal("-KILL").code().is_none());
    }
    let mut server = start(command(), &data);
    load.serve_at(&[&server.url]);
    for id in &ids {
        ends_well(&load, id).await;
    }
    let total = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), total);
    assert!(server.signal("-TERM").success());
    crate::folder::check(&data).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_clock_that_jumps_under_a_server_breaks_nothing() {
    let load = Load::prepare(&Habits::default());
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let shift = folder.path().join("shift");
    let jump = |by: &str| std::fs::write(&shift, by).unwrap();
    jump("+0");
    let mut command = command();
    command
        .env("LD_PRELOAD", faketime())
        .env("FAKETIME_TIMESTAMP_FILE", &shift)
        .env("FAKETIME_NO_CACHE", "1")
        // The clock that only runs forward does not jump on a real machine.
        .env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
    let mut server = start(command, &data);
    load.serve_at(&[&server.url]);
    let mesh = upload(&load).await;
    let mut ids = Vec::new();
    for (by, hours) in [("+0", 0), ("+1h", 1), ("-1h", -1), ("+0", 0)] {
        jump(by);
        for number in 0..6 {
            // Some wait, some run when it jumps next.
            let size = if number < 2 { 60 } else { 5 };
            let job = submit(&load, &mesh, number, size).await;
            let apart = time(&job, "created_at").duration_since(Timestamp::now());
            let hours = SignedDuration::from_hours(hours);
            assert!(
                (apart - hours).abs() < SignedDuration::from_mins(10),
                "{job}"
            );
            ids.push(job["id"].as_str().unwrap().to_owned());
        }
        let ready = load
            .caller
            .call(Method::GET, "/readyz", &Body::Nothing)
            .await;
        assert_eq!(ready.unwrap().status, 200);
    }
    for id in &ids {
        ends_well(&load, id).await;
    }
    let total = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), total);
    assert!(server.signal("-TERM").success());
    crate::folder::check(&data).await;
}
