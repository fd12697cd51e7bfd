//! Disks that are full, read-only or refuse to be written: the real binary.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use reqwest::{Client, Response};
use serde_json::{Value, json};
use tempfile::TempDir;
use testkit::process::{Graspd, binary, ended, get, graspd};

use crate::common::{cuboid, file, problem, small_box};

/// A small disk in memory.
struct Disk(TempDir);

impl Disk {
    /// `None` where none can be mounted, as without the rights to, and GRASPD_ALLOW_SKIP=1 says that this
    /// is all right.
    fn mount(mebibytes: u32) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let size = format!("size={mebibytes}m");
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &size, "tmpfs"])
            .arg(folder.path())
            .stderr(Stdio::null())
            .status();
        if mounted.is_ok_and(|status| status.success()) {
            return Some(Self(folder));
        }
        let may_skip = std::env::var("GRASPD_ALLOW_SKIP").is_ok_and(|value| value == "1");
        assert!(
            may_skip,
            "no disk can be mounted here: run the tests as root, or set GRASPD_ALLOW_SKIP=1"
        );
        eprintln!("SKIPPED: no disk can be mounted here");
        None
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn mode(&self, mode: &str) {
        let remount = format!("remount,{mode}");
        let done = Command::new("mount")
            .args(["-o", &remount])
            .arg(self.0.path())
            .status();
        assert!(done.unwrap().success());
    }

    /// Writes until only about `left` bytes are free.
    fn fill(&self, left: u64) {
        let mut filler = File::create(self.path("filler")).unwrap();
        while filler.write_all(&[1; 4096]).is_ok() {}
        let length = filler.metadata().unwrap().len();
        filler.set_len(length - left.min(length)).unwrap();
    }

    fn free(&self) {
        fs::remove_file(self.path("filler")).unwrap();
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg("-l").arg(self.0.path()).status();
    }
}

fn client() -> Client {
    Client::builder().no_proxy().build().unwrap()
}

/// With no floor to speak of, so that the disk itself refuses.
fn serve(data: &Path) -> Graspd {
    let mut command = graspd(&["serve", "--listen", "127.0.0.1:0", "--min-free-disk", "1"]);
    command.arg("--data-dir").arg(data).stderr(Stdio::null());
    Graspd::launch(&mut command)
}

async fn post(client: &Client, server: &Graspd, path: &str, body: Value) -> Response {
    client
        .post(server.url(path))
        .json(&body)
        .send()
        .await
        .unwrap()
}

async fn upload(client: &Client, server: &Graspd, mesh: Vec<u8>) -> Response {
    let sent = client
        .post(server.url("/meshes"))
        .multipart(file(mesh))
        .send();
    sent.await.unwrap()
}

async fn submitted(client: &Client, server: &Graspd, mesh: &str, generations: u32) -> String {
    let job = json!({"mesh_id": mesh, "population": 100, "generations": generations, "seed": 1});
    let answer = post(client, server, "/jobs", job).await;
    assert_eq!(answer.status(), 202);
    let job: Value = answer.json().await.unwrap();
    job["id"].as_str().unwrap().to_owned()
}

async fn comes_to(client: &Client, server: &Graspd, id: &str, state: &str) -> Value {
    let end = Instant::now() + Duration::from_secs(60);
    loop {
        let job = get(client, server.url(&format!("/jobs/{id}"))).await;
        if job["state"] == state {
            return job;
        }
        assert!(Instant::now() < end, "not {state}: {job}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

async fn becomes_ready(client: &Client, server: &Graspd) {
    let end = Instant::now() + Duration::from_secs(30);
    loop {
        let answer = client.get(server.url("/readyz")).send().await.unwrap();
        if answer.status() == 200 {
            return;
        }
        let why = answer.text().await.unwrap();
        assert!(Instant::now() < end, "{why}");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

fn names(folder: PathBuf) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string();
    entries.map(|entry| name(entry).unwrap()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_full_disk_refuses_work_and_loses_none() {
    let Some(disk) = Disk::mount(24) else { return };
    let (client, data) = (client(), disk.path("data"));
    let mut server = serve(&data);
    let mesh: Value = upload(&client, &server, small_box())
        .await
        .json()
        .await
        .unwrap();
    let mesh = mesh["id"].as_str().unwrap();
    let done = submitted(&client, &server, mesh, 3).await;
    let done = comes_to(&client, &server, &done, "succeeded").await;
    let running = submitted(&client, &server, mesh, 100_000).await;
    comes_to(&client, &server, &running, "running").await;
    let mut queued = Vec::new();
    for _ in 0..20 {
        queued.push(submitted(&client, &server, mesh, 3).await);
    }

    disk.fill(4096);
    // Some still fit into the log that is there.
    let mut accepted = Vec::new();
    let refused = loop {
        let job =
            json!({"mesh_id": mesh, "generations": 3, "population": 10, "label": "x".repeat(100)});
        let answer = post(&client, &server, "/jobs", job).await;
        if answer.status() != 202 {
            break answer;
        }
        let job: Value = answer.json().await.unwrap();
        accepted.push(job["id"].as_str().unwrap().to_owned());
        assert!(accepted.len() < 5000, "the disk is never full");
    };
    let refused = problem(refused, 507).await;
    assert_eq!(refused["type"], "/problems/disk-full");
    let large = cuboid([1.0, 2.0, 3.0], 60);
    problem(upload(&client, &server, large.clone()).await, 507).await;
    let form = file(large.clone()).text("seed", "1");
    let form = client
        .post(server.url("/jobs"))
        .multipart(form)
        .send()
        .await;
    problem(form.unwrap(), 507).await;

    // Nothing half-written, and all that is only read still works.
    assert!(names(data.join("uploads")).is_empty());
    assert_eq!(names(data.join("meshes")), [mesh]);
    let id = done["id"].as_str().unwrap();
    let result = get(&client, server.url(&format!("/jobs/{id}/result"))).await;
    assert_eq!(result, done["result"]);
    for path in ["/jobs", "/meshes", "/healthz", "/metrics"] {
        let answer = client.get(server.url(path)).send().await.unwrap();
        assert_eq!(answer.status(), 200, "{path}");
    }
    let metrics = client.get(server.url("/metrics")).send().await.unwrap();
    let metrics = metrics.text().await.unwrap();
    assert!(
        metrics.contains("graspd_http_rejections_total{reason=\"disk_full\"} 3"),
        "{metrics}"
    );
    let ready = client.get(server.url("/readyz")).send().await.unwrap();
    let ready = problem(ready, 503).await;
    let kind = ready["type"].as_str().unwrap();
    assert!(
        ["/problems/disk-full", "/problems/disk-low"].contains(&kind),
        "{ready}"
    );

    // Cancelling needs room, and has it.
    for id in queued.iter().take(10).chain([&running]) {
        let answer = post(&client, &server, &format!("/jobs/{id}/cancel"), json!({})).await;
        assert_eq!(answer.status(), 202);
        let job = comes_to(&client, &server, id, "cancelled").await;
        assert!(job["finished_at"].is_string(), "{job}");
    }
    let reserve = data.join("graspd.db-reserve");
    assert!(!reserve.exists(), "the room kept for that was not needed");
    // So has the end of a run.
    comes_to(&client, &server, &queued[10], "succeeded").await;

    disk.free();
    becomes_ready(&client, &server).await;
    assert!(reserve.exists(), "no room is kept for the next time");
    for id in queued.iter().skip(10).chain(&accepted) {
        comes_to(&client, &server, id, "succeeded").await;
    }
    assert_eq!(upload(&client, &server, large).await.status(), 201);
    let again = submitted(&client, &server, mesh, 3).await;
    comes_to(&client, &server, &again, "succeeded").await;
    assert!(server.signal("-TERM").success());
    let mut doctor = graspd(&[
        "doctor",
        "--deep",
        "--min-free-disk",
        "1",
        "--listen",
        "127.0.0.1:0",
    ]);
    ended(&doctor.arg("--data-dir").arg(&data).output().unwrap(), 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_end_of_a_run_waits_for_room() {
    let Some(disk) = Disk::mount(24) else { return };
    let (client, data) = (client(), disk.path("data"));
    let server = serve(&data);
    let mesh: Value = upload(&client, &server, small_box())
        .await
        .json()
        .await
        .unwrap();
    let mesh = mesh["id"].as_str().unwrap();
    let running = submitted(&client, &server, mesh, 100_000).await;
    comes_to(&client, &server, &running, "running").await;
    disk.fill(0);
    // Not even the room that is kept is there.
    let spent = fs::remove_file(data.join("graspd.db-reserve"));
    spent.expect("the reserve");
    disk.fill(0);
    // Whether or not the log has room for the cancellation, the job is not lost.
    let cancel = format!("/jobs/{running}/cancel");
    let answer = post(&client, &server, &cancel, json!({})).await;
    assert!([202, 507].contains(&answer.status().as_u16()));
    tokio::time::sleep(Duration::from_secs(2)).await;
    disk.free();
    becomes_ready(&client, &server).await;
    post(&client, &server, &cancel, json!({})).await;
    let job = comes_to(&client, &server, &running, "cancelled").await;
    assert_eq!(job["attempt"], 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_read_only_data_directory_is_refused_at_the_start() {
    let Some(disk) = Disk::mount(16) else { return };
    let data = disk.path("data");
    let mut server = serve(&data);
    assert!(server.signal("-TERM").success());
    disk.mode("ro");
    let mut command = graspd(&["serve", "--listen", "127.0.0.1:0", "--data-dir"]);
    let (out, said) = ended(&command.arg(&data).output().unwrap(), 1);
    assert!(out.is_empty(), "{out}");
    let plain = said.contains(data.to_str().unwrap()) && said.contains("cannot be used");
    assert!(plain && said.to_lowercase().contains("read-only"), "{said}");
    let mut doctor = graspd(&["doctor", "--listen", "127.0.0.1:0", "--data-dir"]);
    let (said, _) = ended(&doctor.arg(&data).output().unwrap(), 1);
    assert!(said.contains("cannot be written"), "{said}");
    disk.mode("rw");
    drop(serve(&data));
}

/// A disk that turns read-only under files that are open for writing cannot be had on command; a
/// limit of zero on the size of files refuses the same writes.
#[tokio::test(flavor = "multi_thread")]
async fn a_store_that_stops_accepting_writes_is_reported_and_recovers() {
    let folder = tempfile::tempdir().unwrap();
    let client = client();
    let mut command = Command::new("sh");
    // Else the first refused write would end the process.
    command.args(["-c", "trap '' XFSZ; exec \"$@\"", "sh"]);
    command.args([
        &binary().display().to_string(),
        "serve",
        "--listen",
        "127.0.0.1:0",
        "--data-dir",
    ]);
    command.arg(folder.path()).stderr(Stdio::null());
    let server = Graspd::launch(&mut command);
    let limit = |bytes: &str| {
        let limit = format!("--fsize={bytes}:");
        let set = Command::new("prlimit")
            .args(["--pid", &server.id(), &limit])
            .status();
        assert!(set.unwrap().success());
    };
    let mesh: Value = upload(&client, &server, small_box())
        .await
        .json()
        .await
        .unwrap();
    let mesh = mesh["id"].as_str().unwrap();
    let job = json!({"mesh_id": mesh, "population": 20, "generations": 3});
    becomes_ready(&client, &server).await;

    limit("0");
    let refused = problem(post(&client, &server, "/jobs", job.clone()).await, 503).await;
    assert_eq!(refused["type"], "/problems/store-unavailable");
    problem(
        upload(&client, &server, cuboid([1.0, 1.0, 1.0], 3)).await,
        503,
    )
    .await;
    let ready = client.get(server.url("/readyz")).send().await.unwrap();
    let ready = problem(ready, 503).await;
    assert_eq!(ready["type"], "/problems/store-unwritable");
    for path in ["/healthz", "/jobs", "/meshes"] {
        let answer = client.get(server.url(path)).send().await.unwrap();
        assert_eq!(answer.status(), 200, "{path}");
    }

    limit("unlimited");
    becomes_ready(&client, &server).await;
    let answer = post(&client, &server, "/jobs", job).await;
    assert_eq!(answer.status(), 202);
    let job: Value = answer.json().await.unwrap();
    comes_to(&client, &server, job["id"].as_str().unwrap(), "succeeded").await;
    let jobs = get(&client, server.url("/jobs")).await;
    assert_eq!(jobs["jobs"].as_array().unwrap().len(), 1);
    assert_eq!(names(folder.path().join("meshes")), [mesh]);
}
