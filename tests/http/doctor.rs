//! `graspd doctor`: what it finds, says and leaves alone.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use reqwest::Client;
use serde_json::Value;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Executor};
use testkit::process::{Graspd, ended, graspd};

use crate::common::{file, small_box};

fn doctor(data: &Path, listen: &str) -> Command {
    let mut command = graspd(&["doctor", "--json", "--min-free-disk", "1"]);
    command.args(["--listen", listen, "--data-dir"]).arg(data);
    command
}

/// Runs it and gives the report.
fn report(command: &mut Command, code: i32) -> Value {
    let (said, _) = ended(&command.output().unwrap(), code);
    let report: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(report["ok"], code == 0, "{said}");
    for finding in report["findings"].as_array().unwrap() {
        let advised = finding["advice"].is_string();
        assert_eq!(advised, finding["status"] != "ok", "{finding}");
    }
    report
}

fn finding<'a>(report: &'a Value, check: &str) -> (&'a str, &'a str) {
    let findings = report["findings"].as_array().unwrap();
    let found = findings.iter().find(|finding| finding["check"] == check);
    let found = found.unwrap_or_else(|| panic!("no {check} in {report}"));
    (
        found["status"].as_str().unwrap(),
        found["detail"].as_str().unwrap(),
    )
}

/// Every file below `folder` with its bytes and the time of its last change.
fn listing(folder: &Path) -> BTreeMap<String, (Vec<u8>, std::time::SystemTime)> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let changed = path.metadata().unwrap().modified().unwrap();
                let bytes = std::fs::read(&path).unwrap();
                found.insert(path.to_str().unwrap().to_owned(), (bytes, changed));
            }
        }
    }
    found
}

async fn upload(server: &Graspd) -> String {
    let client = Client::builder().no_proxy().build().unwrap();
    let form = file(small_box())
        .text("population", "20")
        .text("generations", "3");
    let job = client
        .post(server.url("/jobs"))
        .multipart(form)
        .send()
        .await;
    let job: Value = job.unwrap().json().await.unwrap();
    job["mesh_id"].as_str().unwrap().to_owned()
}

async fn alter(data: &Path, statement: &'static str) {
    let options = SqliteConnectOptions::new().filename(data.join("graspd.db"));
    let mut database = options.connect().await.unwrap();
    database.execute(statement).await.unwrap();
    sqlx::Connection::close(database).await.unwrap();
}

#[test]
fn settings_are_printed_with_their_sources() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("none yet");
    let mut command = doctor(&data, "127.0.0.1:0");
    command.args(["--workers", "2"]);
    command
        .env("GRASPD_QUEUE_CAPACITY", "5")
        .env("GRASPD_WORKRES", "3");
    let report = report(&mut command, 0);
    assert!(!data.exists());
    assert_eq!(finding(&report, "data directory").0, "ok");
    let (status, odd) = finding(&report, "environment");
    assert!(
        status == "warning" && odd.contains("GRASPD_WORKRES"),
        "{odd}"
    );
    for (flag, value, source) in [
        ("--workers", Some("2"), "flag"),
        ("--queue-capacity", Some("5"), "environment"),
        ("--max-triangles", Some("2000000"), "default"),
        ("--threads-per-job", None, "default"),
    ] {
        let settings = report["settings"].as_array().unwrap();
        let setting = settings
            .iter()
            .find(|setting| setting["flag"] == flag)
            .unwrap();
        assert_eq!(setting["value"].as_str(), value, "{setting}");
        assert_eq!(setting["source"], source, "{setting}");
    }
    let bad = graspd(&["doctor", "--no-such-flag"]).output().unwrap();
    ended(&bad, 2);
    let mut people = graspd(&["doctor", "--listen", "127.0.0.1:0", "--data-dir"]);
    let (said, _) = ended(&people.arg(&data).output().unwrap(), 0);
    assert!(said.contains("--workers = 1  (default)"), "{said}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_running_and_a_stopped_server_are_examined() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let mut server = Graspd::start(&data);
    let mesh = upload(&server).await;
    let address = server.url.trim_start_matches("http://").to_owned();
    let found = report(doctor(&data, &address).arg("--deep"), 0);
    let (_, lock) = finding(&found, "lock");
    assert!(
        lock.contains(&server.id()) || lock == "held by a server",
        "{lock}"
    );
    assert!(finding(&found, "address").1.contains("is ready"), "{found}");
    assert!(server.signal("-TERM").success());

    let before = listing(&data);
    let found = report(doctor(&data, &address).arg("--deep"), 0);
    assert!(finding(&found, "lock").1.starts_with("free"), "{found}");
    assert!(finding(&found, "address").1.contains("is free"), "{found}");
    assert_eq!(finding(&found, "journal").1, "write-ahead log");
    assert!(before == listing(&data), "it changed something");

    // What a crash leaves: a log that is not part of the database yet.
    let mut server = Graspd::start(&data);
    upload(&server).await;
    server.signal("-KILL");
    let names: Vec<_> = listing(&data).into_keys().collect();
    report(&mut doctor(&data, "127.0.0.1:0"), 0);
    assert_eq!(names, listing(&data).into_keys().collect::<Vec<_>>());
    drop(Graspd::start(&data));

    let kept = data.join("meshes").join(&mesh);
    let bytes = std::fs::read(&kept).unwrap();
    let mut flipped = bytes.clone();
    flipped[100] ^= 1;
    std::fs::write(&kept, flipped).unwrap();
    report(&mut doctor(&data, "127.0.0.1:0"), 0);
    let found = report(doctor(&data, "127.0.0.1:0").arg("--deep"), 1);
    assert!(finding(&found, "mesh files").1.contains(&mesh), "{found}");

    let stray = data.join("meshes").join("0".repeat(64));
    std::fs::rename(&kept, &stray).unwrap();
    let found = report(&mut doctor(&data, "127.0.0.1:0"), 1);
    assert_eq!(finding(&found, "meshes").0, "wrong");
    std::fs::write(&kept, bytes).unwrap();
    let found = report(&mut doctor(&data, "127.0.0.1:0"), 0);
    assert_eq!(finding(&found, "meshes").0, "warning");
}

#[tokio::test(flavor = "multi_thread")]
async fn faults_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let mut server = Graspd::start(&data);
    upload(&server).await;
    assert!(server.signal("-TERM").success());

    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let found = report(&mut doctor(&data, &address), 1);
    assert_eq!(finding(&found, "address").0, "wrong");
    let found = report(&mut doctor(&data, "no address"), 1);
    assert_eq!(finding(&found, "address").0, "wrong");

    // The year 2096.
    alter(&data, "UPDATE jobs SET created_at = 4000000000000000").await;
    let found = report(&mut doctor(&data, "127.0.0.1:0"), 1);
    assert_eq!(finding(&found, "newest job").0, "wrong");
    alter(&data, "UPDATE jobs SET created_at = 1").await;
    report(&mut doctor(&data, "127.0.0.1:0"), 0);

    alter(
        &data,
        "UPDATE _sqlx_migrations SET version = 9000 WHERE version = 1",
    )
    .await;
    let found = report(&mut doctor(&data, "127.0.0.1:0"), 1);
    assert_eq!(finding(&found, "tables").0, "wrong");
    alter(
        &data,
        "UPDATE _sqlx_migrations SET version = 1 WHERE version = 9000",
    )
    .await;

    let database = data.join("graspd.db");
    let mut bytes = std::fs::read(&database).unwrap();
    // All but the first page, which says where the others are.
    bytes[4096..].fill(0xff);
    std::fs::write(&database, bytes).unwrap();
    report(&mut doctor(&data, "127.0.0.1:0"), 1);
}

#[test]
fn settings_that_prevent_a_start_are_reported_in_the_words_of_the_server() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let found = report(&mut doctor(&data, "127.0.0.1:0"), 0);
    for check in ["API keys", "webhooks", "CORS", "log level", "memory"] {
        assert_eq!(finding(&found, check).0, "ok", "{found}");
    }
    for (check, flags) in [
        ("API keys", ["--listen", "0.0.0.0:0"]),
        ("webhooks", ["--webhook-hosts", "a.example"]),
        ("CORS", ["--cors-origins", "a.example"]),
        ("log level", ["--log-level", "info,=,"]),
    ] {
        let mut server = graspd(&["serve", "--data-dir", data.to_str().unwrap()]);
        if check != "API keys" {
            server.args(["--listen", "127.0.0.1:0"]);
        }
        let (_, refused) = ended(&server.args(flags).output().unwrap(), 1);
        let mut doctor = graspd(&["doctor", "--json", "--min-free-disk", "1", "--data-dir"]);
        doctor.arg(&data);
        if check != "API keys" {
            doctor.args(["--listen", "127.0.0.1:0"]);
        }
        let found = report(doctor.args(flags), 1);
        let (status, detail) = finding(&found, check);
        assert_eq!(status, "wrong", "{found}");
        assert_eq!(refused.trim(), format!("graspd: {detail}"));
    }
    let mut doctor = doctor(&data, "127.0.0.1:0");
    let found = report(doctor.args(["--max-memory", "100000GiB"]), 0);
    assert_eq!(finding(&found, "memory").0, "warning", "{found}");
}
