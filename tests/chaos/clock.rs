//! The clock of the machine set an hour forward, then an hour back, while jobs wait.

use std::path::PathBuf;
use std::process::Command;

use jiff::Timestamp;
use reqwest::Method;
use serde_json::{Value, json};

use crate::client::Body;
use crate::load::{Load, command, start};

/// The library that shifts the clock of a process; installed when it is missing.
fn faketime() -> PathBuf {
    let found = || {
        let folders = std::fs::read_dir("/usr/lib").into_iter().flatten();
        folders
            .filter_map(|entry| Some(entry.ok()?.path().join("faketime/libfaketime.so.1")))
            .find(|path| path.exists())
    };
    found().unwrap_or_else(|| {
        let script = "apt-get update && apt-get install --yes libfaketime";
        let installed = Command::new("sh").args(["-c", script]).output();
        assert!(
            installed.is_ok_and(|output| output.status.success()),
            "{script} fails"
        );
        found().expect("libfaketime")
    })
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

#[tokio::test(flavor = "multi_thread")]
async fn a_clock_that_jumps_breaks_nothing() {
    faketime();
    let load = Load::prepare();
    let data = load.data();
    let mut ids = Vec::new();
    let mut mesh = String::new();
    for shift in ["+1h", "-1h", "+0"] {
        let mut server = start(shifted(shift), &data);
        load.serve_at(&server.url);
        if mesh.is_empty() {
            let body = Body::Mesh(&load.orders[0].mesh);
            let answer = load.caller.call(Method::POST, "/meshes", &body).await;
            mesh = answer.unwrap().body["id"].as_str().unwrap().to_owned();
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
    load.serve_at(&server.url);
    for id in &ids {
        let path = format!("/jobs/{id}");
        let view = loop {
            let answer = load.caller.call(Method::GET, &path, &Body::Nothing).await;
            let view = answer.unwrap().body;
            match view["state"].as_str().unwrap() {
                "queued" | "running" => {
                    tokio::time::sleep(std::time::Duration::from_millis(50)).await;
                }
                _ => break view,
            }
        };
        assert_eq!(view["state"], "succeeded", "{view}");
        let times = ["created_at", "started_at", "finished_at"];
        let times = times.map(|name| view[name].as_str().unwrap().parse::<Timestamp>().unwrap());
        assert!(times.is_sorted(), "{view}");
        assert!(view["result"]["elapsed_s"].as_f64().unwrap() >= 0.0);
    }
    let total = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), total);
    assert!(server.signal("-TERM").success());
    crate::verdict::check_folder(&data).await;
}
