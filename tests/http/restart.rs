//! The real binary: what it prints, how it stops, and what survives when it is killed.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use reqwest::Client;
use serde_json::{Value, json};
#[cfg(not(feature = "otel"))]
use testkit::process::graspd;
use testkit::process::{Graspd, get};

use crate::common::{file, small_box};

#[tokio::test(flavor = "multi_thread")]
async fn a_killed_server_loses_no_acknowledged_job() {
    let folder = tempfile::tempdir().unwrap();
    let client = Client::builder().no_proxy().build().unwrap();
    let mut server = Graspd::start(folder.path());
    let mut jobs = Vec::new();
    for seed in 0..12 {
        let form = file(small_box())
            .text("population", "30")
            .text("generations", "30")
            .text("candidates", "triangles")
            .text("seed", seed.to_string());
        let answer = client
            .post(format!("{}/jobs", server.url))
            .multipart(form)
            .send()
            .await
            .unwrap();
        assert_eq!(answer.status(), 202);
        let job: Value = answer.json().await.unwrap();
        jobs.push(job["id"].as_str().unwrap().to_owned());
    }
    server.signal("-KILL");
    drop(server);

    let start = Instant::now();
    let mut server = Graspd::start(folder.path());
    assert!(
        start.elapsed() < Duration::from_secs(2),
        "ready after {:?}",
        start.elapsed()
    );
    let end = Instant::now() + Duration::from_secs(120);
    for (seed, id) in jobs.iter().enumerate() {
        loop {
            let job = get(&client, format!("{}/jobs/{id}", server.url)).await;
            if job["state"] == "succeeded" {
                break;
            }
            assert!(
                ["queued", "running"].contains(&job["state"].as_str().unwrap()),
                "{job}"
            );
            assert!(Instant::now() < end, "{job}");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        let result = get(&client, format!("{}/jobs/{id}/result", server.url)).await;
        assert_eq!(result["seed"], json!(seed));
    }
    let list = get(&client, format!("{}/jobs", server.url)).await;
    assert_eq!(list["jobs"].as_array().unwrap().len(), jobs.len());
    assert!(server.signal("-TERM").success());
}

#[tokio::test(flavor = "multi_thread")]
async fn revisions_that_clients_have_seen_are_not_seen_again_after_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let client = Client::builder().no_proxy().build().unwrap();
    let mut server = Graspd::start(folder.path());
    let form = file(small_box())
        .text("population", "10000")
        .text("generations", "90000");
    let answer = client.post(format!("{}/jobs", server.url)).multipart(form);
    let job: Value = answer.send().await.unwrap().json().await.unwrap();
    let id = job["id"].as_str().unwrap().to_owned();
    let mut seen = 0;
    let end = Instant::now() + Duration::from_secs(60);
    while seen < 20 {
        let job = get(&client, format!("{}/jobs/{id}", server.url)).await;
        seen = job["revision"].as_u64().unwrap();
        assert!(Instant::now() < end, "{job}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    server.signal("-KILL");
    drop(server);
    let server = Graspd::start(folder.path());
    let again = get(&client, format!("{}/jobs/{id}", server.url)).await;
    assert!(again["revision"].as_u64().unwrap() > seen, "{again}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stopped_server_puts_its_job_back_without_burning_an_attempt() {
    let folder = tempfile::tempdir().unwrap();
    let client = Client::builder().no_proxy().build().unwrap();
    let mut server = Graspd::start(folder.path());
    let form = file(small_box())
        .text("population", "10000")
        .text("generations", "90000");
    let answer = client
        .post(format!("{}/jobs", server.url))
        .multipart(form)
        .send()
        .await
        .unwrap();
    let id = answer.json::<Value>().await.unwrap()["id"]
        .as_str()
        .unwrap()
        .to_owned();
    let running = loop {
        let job = get(&client, format!("{}/jobs/{id}", server.url)).await;
        if job["state"] == "running" {
            break job;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    };
    let start = Instant::now();
    assert!(server.signal("-TERM").success());
    assert!(
        start.elapsed() < Duration::from_secs(25),
        "{:?}",
        start.elapsed()
    );
    drop(server);

    let mut server = Graspd::start(folder.path());
    let again = loop {
        let job = get(&client, format!("{}/jobs/{id}", server.url)).await;
        assert!(
            ["queued", "running"].contains(&job["state"].as_str().unwrap()),
            "{job}"
        );
        if job["state"] == "running" {
            break job;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    };
    assert_eq!(again["attempt"], running["attempt"]);
    assert_eq!(again["request"], running["request"]);
    assert!(server.signal("-INT").success());
}

#[test]
fn faults_that_prevent_a_start_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let output = Command::new(testkit::process::binary())
        .args(["serve", "--listen", &address, "--data-dir"])
        .arg(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains(&address), "{said}");
    assert!(output.stdout.is_empty());

    let server = Graspd::start(folder.path());
    let output = Command::new(testkit::process::binary())
        .args(["serve", "--listen", "127.0.0.1:0", "--data-dir"])
        .arg(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("in use by another graspd"), "{said}");
    drop(server);
}

#[tokio::test(flavor = "multi_thread")]
async fn logs_that_nobody_takes_do_no_harm() {
    let client = Client::builder().no_proxy().build().unwrap();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
    for (logs, requests) in [(Stdio::from(full.unwrap()), 500), (Stdio::piped(), 5000)] {
        let folder = tempfile::tempdir().unwrap();
        let mut server = Graspd::start_with(folder.path(), &[], logs);
        for _ in 0..requests {
            let health = get(&client, format!("{}/healthz", server.url)).await;
            assert_eq!(health["status"], "ok");
        }
        assert!(server.signal("-TERM").success());
    }
}

#[cfg(not(feature = "otel"))]
#[test]
fn traces_that_go_nowhere_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    for (endpoint, warns) in [("http://127.0.0.1:1", true), ("", false)] {
        let logs = folder.path().join("log");
        let mut command = graspd(&[]);
        command
            .env("OTEL_EXPORTER_OTLP_ENDPOINT", endpoint)
            .stderr(std::fs::File::create(&logs).unwrap());
        let mut server = Graspd::spawn(command, &folder.path().join("data"), &[]);
        assert!(server.signal("-TERM").success());
        let said = std::fs::read_to_string(&logs).unwrap();
        let warned = said.contains("OTEL_EXPORTER_OTLP_ENDPOINT is set, but");
        assert_eq!(warned, warns, "{said}");
    }
}

#[test]
fn a_closed_pipe_is_no_fault() {
    let mut writer = Command::new(testkit::process::binary())
        .arg("openapi")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(writer.stdout.take());
    let output = writer.wait_with_output().unwrap();
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{output:?}"
    );
}

#[test]
fn planning_without_a_server_has_its_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("box.stl");
    std::fs::write(&mesh, small_box()).unwrap();
    let text = folder.path().join("text.stl");
    std::fs::write(&text, "no mesh at all").unwrap();
    let plan = |file: &Path, flags: &[&str]| {
        Command::new(testkit::process::binary())
            .arg("plan")
            .arg(file)
            .args(["--population", "20", "--generations", "3", "--seed", "7"])
            .args(flags)
            .output()
            .unwrap()
    };
    let found = plan(&mesh, &[]);
    assert_eq!(found.status.code(), Some(0), "{found:?}");
    assert!(String::from_utf8_lossy(&found.stdout).contains("force closure, quality"));
    let one = plan(&mesh, &["--json", "--threads", "1"]);
    let two = plan(&mesh, &["--json", "--threads", "2"]);
    let read = |bytes: &[u8]| -> Value {
        let mut value: Value = serde_json::from_slice(bytes).unwrap();
        value["elapsed_s"] = Value::Null;
        value["history"] = Value::Null;
        value
    };
    assert_eq!(read(&one.stdout), read(&two.stdout));
    assert_eq!(plan(&text, &[]).status.code(), Some(1));
    assert_eq!(
        plan(&folder.path().join("none"), &[]).status.code(),
        Some(1)
    );
    assert_eq!(plan(&mesh, &["--friction=-1"]).status.code(), Some(2));
    assert_eq!(plan(&mesh, &["--no-such-flag"]).status.code(), Some(2));
    let none = plan(
        &mesh,
        &["--contacts", "2", "--contact-model", "frictionless"],
    );
    assert_eq!(none.status.code(), Some(3), "{none:?}");
}
