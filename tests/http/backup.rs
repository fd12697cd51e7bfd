//! Backup while a server runs and works, and restore elsewhere: the real binary.

use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::Output;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use reqwest::Client;
use serde_json::{Value, json};
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Executor};
use testkit::process::{Graspd, ended, get, graspd};

use crate::common::{cuboid, file, small_box};

fn back_up(data: &Path, target: &Path) -> Output {
    let data = data.to_str().unwrap();
    let mut command = graspd(&["backup", "--data-dir", data]);
    command.arg(target).output().unwrap()
}

fn restore(backup: &Path, data: &Path) -> Output {
    let data = data.to_str().unwrap();
    let mut command = graspd(&["restore", "--data-dir", data]);
    command.arg(backup).output().unwrap()
}

/// Submits a job with a mesh file and gives it once it is acknowledged.
async fn submit(client: &Client, server: &Graspd, mesh: Vec<u8>, seed: u64) -> Value {
    let form = file(mesh)
        .text("population", "20")
        .text("generations", "3")
        .text("seed", seed.to_string());
    let answer = client
        .post(server.url("/jobs"))
        .multipart(form)
        .send()
        .await;
    let answer = answer.unwrap();
    assert_eq!(answer.status(), 202);
    answer.json().await.unwrap()
}

async fn succeeded(client: &Client, server: &Graspd, id: &str) -> Value {
    let end = Instant::now() + Duration::from_secs(120);
    loop {
        let job = get(client, server.url(&format!("/jobs/{id}"))).await;
        if job["state"] == "succeeded" {
            return job;
        }
        let state = job["state"].as_str().unwrap_or("no state");
        assert!(["queued", "running"].contains(&state), "{job}");
        assert!(Instant::now() < end, "{job}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// A result without what time it took.
fn timeless(result: &Value) -> Value {
    let mut result = result.clone();
    result["elapsed_s"] = Value::Null;
    for generation in result["history"].as_array_mut().into_iter().flatten() {
        generation["elapsed_s"] = Value::Null;
    }
    result
}

#[tokio::test(flavor = "multi_thread")]
async fn a_backup_under_load_contains_everything_acknowledged_before() {
    let folder = tempfile::tempdir().unwrap();
    let [data, target, elsewhere] =
        ["data", "backup", "restored"].map(|name| folder.path().join(name));
    let client = Client::builder().no_proxy().build().unwrap();
    let server = Arc::new(Graspd::start(&data));

    let first = submit(&client, &server, small_box(), 7).await;
    let first = succeeded(&client, &server, first["id"].as_str().unwrap()).await;
    // More work than will be done by then, and meshes that come and go meanwhile.
    let working = Arc::new(AtomicBool::new(true));
    let load = [1, 2].map(|lane: u64| {
        let (client, server, working) = (client.clone(), Arc::clone(&server), Arc::clone(&working));
        tokio::spawn(async move {
            let mut count = 0;
            while working.load(Ordering::Relaxed) {
                count += 1;
                let side = (lane * 1000 + count) as f32;
                submit(&client, &server, cuboid([1.0, 2.0, side], 2), count).await;
                let gone = file(cuboid([1.0, 3.0, side], 2));
                let gone = client
                    .post(server.url("/meshes"))
                    .multipart(gone)
                    .send()
                    .await;
                let gone: Value = gone.unwrap().json().await.unwrap();
                let path = format!("/meshes/{}", gone["id"].as_str().unwrap());
                client.delete(server.url(&path)).send().await.unwrap();
            }
        })
    });
    let mut acknowledged = vec![first.clone()];
    for seed in 0..40 {
        acknowledged.push(submit(&client, &server, cuboid([1.0, 2.0, 3.0], 3), seed).await);
    }
    let backing = {
        let (data, target) = (data.clone(), target.clone());
        tokio::task::spawn_blocking(move || back_up(&data, &target))
    };
    let (said, _) = ended(&backing.await.unwrap(), 0);
    assert!(said.starts_with("backed up "), "{said}");
    working.store(false, Ordering::Relaxed);
    for lane in load {
        lane.await.unwrap();
    }
    let mut server = Arc::into_inner(server).unwrap();
    server.signal("-KILL");
    drop(server);
    std::fs::remove_dir_all(&data).unwrap();

    let (said, _) = ended(&restore(&target, &elsewhere), 0);
    assert!(said.starts_with("restored "), "{said}");
    let server = Graspd::start(&elsewhere);
    for job in &acknowledged {
        let id = job["id"].as_str().unwrap();
        let job = succeeded(&client, &server, id).await;
        assert!(job["result"]["quality"].is_number(), "{job}");
        // No attempt was burned by the backup.
        assert_eq!(job["attempt"], 1);
        let mesh = job["mesh_id"].as_str().unwrap();
        let drawn = client
            .get(server.url(&format!("/meshes/{mesh}/preview.svg")))
            .send()
            .await;
        assert_eq!(drawn.unwrap().status(), 200);
    }
    let kept = get(
        &client,
        server.url(&format!("/jobs/{}", first["id"].as_str().unwrap())),
    )
    .await;
    assert_eq!(kept["result"], first["result"]);
    let again = submit(&client, &server, small_box(), 7).await;
    assert_eq!(again["mesh_id"], first["mesh_id"]);
    let again = succeeded(&client, &server, again["id"].as_str().unwrap()).await;
    assert_eq!(timeless(&again["result"]), timeless(&first["result"]));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_backup_is_whole_or_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let [data, target, other] = ["data", "backup", "other"].map(|name| folder.path().join(name));
    let client = Client::builder().no_proxy().build().unwrap();
    let names = || {
        let entries = std::fs::read_dir(folder.path()).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };

    let (_, said) = ended(&back_up(&data, &target), 1);
    assert!(said.contains("data"), "{said}");
    assert!(names().is_empty(), "{:?}", names());

    let mut server = Graspd::start(&data);
    let mesh = client
        .post(server.url("/meshes"))
        .multipart(file(small_box()))
        .send()
        .await;
    let mesh: Value = mesh.unwrap().json().await.unwrap();
    let mesh = mesh["id"].as_str().unwrap();
    assert!(server.signal("-TERM").success());
    // No server need run, and another file system will do.
    ended(&back_up(&data, &target), 0);
    if let Ok(memory) = tempfile::tempdir_in("/dev/shm") {
        ended(&back_up(&data, &memory.path().join("backup")), 0);
    }
    let (_, said) = ended(&back_up(&data, &target), 1);
    assert!(said.contains("is there already"), "{said}");

    for full in [&data, &target] {
        let (_, said) = ended(&restore(&target, full), 1);
        assert!(said.contains("missing or empty"), "{said}");
    }
    // One bit of one mesh.
    std::fs::remove_file(data.join("meshes").join(mesh)).unwrap();
    let path = target.join("meshes").join(mesh);
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[100] ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    let before = names();
    let (_, said) = ended(&restore(&target, &other), 1);
    assert!(said.contains("damaged") && said.contains(mesh), "{said}");
    assert_eq!(names(), before);
    bytes[100] ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    ended(&restore(&target, &other), 0);
    let server = Graspd::start(&other);
    let list = get(&client, server.url("/meshes")).await;
    assert_eq!(list["meshes"][0]["id"], json!(mesh));
}

/// Such as the place where a volume is mounted, which nothing can be renamed to.
#[tokio::test(flavor = "multi_thread")]
async fn an_empty_folder_is_filled_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let [data, target, empty] = ["data", "backup", "empty"].map(|name| folder.path().join(name));
    let client = Client::builder().no_proxy().build().unwrap();
    let mut server = Graspd::start(&data);
    let job = submit(&client, &server, small_box(), 7).await;
    let id = job["id"].as_str().unwrap();
    let job = succeeded(&client, &server, id).await;
    assert!(server.signal("-TERM").success());
    ended(&back_up(&data, &target), 0);

    std::fs::create_dir(&empty).unwrap();
    let inode = || std::fs::metadata(&empty).unwrap().ino();
    let before = inode();
    let names = || {
        let entries = std::fs::read_dir(&empty).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let path = target.join("meshes").join(job["mesh_id"].as_str().unwrap());
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[1..]).unwrap();
    let (_, said) = ended(&restore(&target, &empty), 1);
    assert!(said.contains("damaged"), "{said}");
    assert!(names().is_empty(), "{:?}", names());
    std::fs::write(&path, &bytes).unwrap();

    // The root of a file system has this from the start.
    std::fs::create_dir(empty.join("lost+found")).unwrap();
    ended(&restore(&target, &empty), 0);
    assert_eq!(inode(), before);
    assert_eq!(names(), ["graspd.db", "lock", "lost+found", "meshes"]);
    let server = Graspd::start(&empty);
    let kept = get(&client, server.url(&format!("/jobs/{id}"))).await;
    assert_eq!(kept["result"], job["result"]);
    let (_, said) = ended(&restore(&target, &empty), 1);
    assert!(said.contains("missing or empty"), "{said}");
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_runs_in_a_backup() {
    let folder = tempfile::tempdir().unwrap();
    let [data, target] = ["data", "backup"].map(|name| folder.path().join(name));
    let client = Client::builder().no_proxy().build().unwrap();
    let mut server = Graspd::start(&data);
    let mut jobs = Vec::new();
    for seed in 0..2 {
        jobs.push(submit(&client, &server, small_box(), seed).await);
        let id = jobs[seed as usize]["id"].as_str().unwrap();
        succeeded(&client, &server, id).await;
    }
    assert!(server.signal("-TERM").success());
    // As they stand while they run, one of them for no longer than it takes to stop it.
    let options = SqliteConnectOptions::new().filename(data.join("graspd.db"));
    let mut database = options.connect().await.unwrap();
    let runs = "UPDATE jobs SET state = 'running', lease = 'x', finished_at = NULL, result = NULL";
    for statement in [
        "DROP TRIGGER jobs_legal_transition",
        runs,
        "UPDATE jobs SET cancel_requested = 1 WHERE id = (SELECT max(id) FROM jobs)",
    ] {
        database.execute(statement).await.unwrap();
    }
    sqlx::Connection::close(database).await.unwrap();
    ended(&back_up(&data, &target), 0);
    let options = SqliteConnectOptions::new().filename(target.join("graspd.db"));
    let mut copy = options.connect().await.unwrap();
    let states: Vec<(String, bool, bool)> = sqlx::query_as(
        "SELECT state, started_at IS NULL, finished_at IS NULL FROM jobs ORDER BY id",
    )
    .fetch_all(&mut copy)
    .await
    .unwrap();
    assert_eq!(
        states,
        [
            ("queued".to_owned(), true, true),
            ("cancelled".to_owned(), false, false)
        ]
    );
}
