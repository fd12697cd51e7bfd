//! Readiness: it fails with the cause, in time, and recovers by itself.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Executor};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::common::{Server, file, problem, server, server_with, small_box};

async fn cause(server: &Server) -> Option<String> {
    let answer = server.get("/readyz").send().await.unwrap();
    if answer.status() == 200 {
        return None;
    }
    assert!(answer.headers().contains_key("retry-after"));
    let problem = problem(answer, 503).await;
    let kind = problem["type"].as_str().unwrap();
    Some(kind.trim_start_matches("/problems/").to_owned())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_database_that_hangs_is_reported_in_time() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    assert_eq!(cause(&server).await, None);
    // The upload is a fresh proof that the store can be written.
    tokio::time::sleep(Duration::from_millis(5100)).await;
    let database = server.folder.path().join("data/graspd.db");
    let options = SqliteConnectOptions::new().filename(database);
    let mut other = options.connect().await.unwrap();
    other.execute("BEGIN IMMEDIATE").await.unwrap();
    for _ in 0..3 {
        let clock = Instant::now();
        assert_eq!(cause(&server).await.as_deref(), Some("store-slow"));
        assert!(
            clock.elapsed() < Duration::from_secs(2),
            "{:?}",
            clock.elapsed()
        );
    }
    // Liveness and reading are another matter.
    server.json("/healthz").await;
    server.json(&format!("/meshes/{mesh}")).await;
    other.execute("ROLLBACK").await.unwrap();
    let end = Instant::now() + Duration::from_secs(30);
    while let Some(cause) = cause(&server).await {
        assert!(Instant::now() < end, "still {cause}");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_drain_is_reported_by_name() {
    let server = server().await;
    server.service.begin_drain();
    assert_eq!(cause(&server).await.as_deref(), Some("draining"));
}

#[tokio::test(flavor = "multi_thread")]
async fn too_little_free_disk_refuses_work_before_it_is_received() {
    // No disk is that large.
    let server = server_with(&["--min-free-disk", "1000000000GiB"]).await;
    assert_eq!(cause(&server).await.as_deref(), Some("disk-low"));
    let job: Value = json!({"mesh_id": "0".repeat(64)});
    for request in [
        server.post("/meshes").multipart(file(small_box())),
        server.post("/jobs").multipart(file(small_box())),
        server.post("/jobs").json(&job),
    ] {
        problem(request.send().await.unwrap(), 507).await;
    }
    // Not one byte of the body is sent.
    let mut stream = TcpStream::connect(("127.0.0.1", server.port))
        .await
        .unwrap();
    let head = "POST /meshes HTTP/1.1\r\nHost: x\r\nContent-Type: model/stl\r\n\
                Content-Length: 1000000\r\nExpect: 100-continue\r\n\r\n";
    stream.write_all(head.as_bytes()).await.unwrap();
    let mut answer = [0; 12];
    let read = stream.read_exact(&mut answer);
    tokio::time::timeout(Duration::from_secs(10), read)
        .await
        .unwrap()
        .unwrap();
    assert_eq!(&answer, b"HTTP/1.1 507");
    for path in ["/healthz", "/meshes", "/jobs", "/metrics"] {
        assert_eq!(
            server.get(path).send().await.unwrap().status(),
            200,
            "{path}"
        );
    }
    assert!(server.kept_files().is_empty(), "{:?}", server.kept_files());
}
