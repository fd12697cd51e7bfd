//! Peers that take their time. All of them at once: each takes a quarter of a minute.

use std::time::{Duration, Instant};

use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::common::{Server, cuboid, server};
use crate::raw::{assert_alive, assert_problem, connect, rest};

/// Sends `start`, then one piece of `rest` every half second until all is sent or the server ends
/// the connection. Answers all that came back, and after how long it ended.
async fn dribble(server: &Server, start: &[u8], pieces: Vec<Vec<u8>>) -> (String, Duration) {
    let begun = Instant::now();
    let (mut input, mut output) = connect(server).await.into_split();
    output.write_all(start).await.unwrap();
    let sending = tokio::spawn(async move {
        for piece in pieces {
            tokio::time::sleep(Duration::from_millis(500)).await;
            if output.write_all(&piece).await.is_err() {
                break;
            }
        }
        output
    });
    let mut answer = Vec::new();
    let read = input.read_to_end(&mut answer);
    let _ = tokio::time::timeout(Duration::from_secs(60), read)
        .await
        .expect("an end");
    sending.abort();
    (
        String::from_utf8_lossy(&answer).into_owned(),
        begun.elapsed(),
    )
}

fn head(path: &str, headers: &str) -> Vec<u8> {
    format!("POST {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n{headers}\r\n").into_bytes()
}

/// The promise is 15 s; a busy machine may take longer to see to it.
fn assert_in_time(what: &str, took: Duration) {
    let seconds = took.as_secs_f64();
    assert!((13.0..40.0).contains(&seconds), "{what}: {seconds} s");
}

async fn slow_head(server: &Server) {
    let letters = vec![b"x".to_vec(); 120];
    let (answer, took) = dribble(server, b"GET /healthz HTTP/1.1\r\nX-Slow: ", letters).await;
    assert_eq!(answer, "");
    assert_in_time("a head", took);
}

async fn silence(server: &Server) {
    let (answer, took) = dribble(server, b"", Vec::new()).await;
    assert_eq!(answer, "");
    assert_in_time("silence", took);
}

async fn idle_between_requests(server: &Server) {
    let begun = Instant::now();
    let mut stream: TcpStream = connect(server).await;
    let request = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n";
    stream.write_all(request).await.unwrap();
    let answer = rest(&mut stream).await;
    assert_eq!(answer.matches("HTTP/1.1 200 ").count(), 1);
    assert_in_time("idle", begun.elapsed());
}

async fn slow_body(server: &Server, path: &str, headers: &str, start: &[u8]) {
    let start = [head(path, headers), start.to_vec()].concat();
    let (answer, took) = dribble(server, &start, vec![b" ".to_vec(); 120]).await;
    assert_problem(&answer, 408);
    assert_in_time(headers, took);
}

/// More than 1 KiB/s is slow, but not too slow.
async fn patient_upload(server: &Server) {
    let mesh = cuboid([1.0, 2.0, 3.0], 7);
    let headers = format!(
        "Content-Type: model/stl\r\nContent-Length: {}\r\n",
        mesh.len()
    );
    let pieces: Vec<Vec<u8>> = mesh.chunks(800).map(<[u8]>::to_vec).collect();
    let (answer, took) = dribble(server, &head("/meshes", &headers), pieces).await;
    assert!(answer.starts_with("HTTP/1.1 201 "), "{answer}");
    assert!(took > Duration::from_secs(16), "{took:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn slow_clients_are_cut_off_and_no_others() {
    let server = server().await;
    let json = "Content-Type: application/json\r\nContent-Length: 1000\r\n";
    let mesh = "Content-Type: model/stl\r\nTransfer-Encoding: chunked\r\n";
    let form = "Content-Type: multipart/form-data; boundary=b\r\nContent-Length: 100000\r\n";
    let part = b"--b\r\nContent-Disposition: form-data; name=\"mesh\"\r\n\r\nsolid";
    tokio::join!(
        slow_head(&server),
        silence(&server),
        idle_between_requests(&server),
        slow_body(&server, "/jobs", json, b"{"),
        slow_body(&server, "/evaluations", json, b""),
        slow_body(&server, "/meshes", mesh, b"3e8\r\nsolid"),
        slow_body(&server, "/jobs", form, part),
        slow_body(&server, "/evaluations", form, part),
        patient_upload(&server),
    );
    let meshes = server.json("/meshes").await;
    assert_eq!(meshes["meshes"].as_array().unwrap().len(), 1);
    assert_eq!(server.json("/jobs").await["jobs"], json!([]));
    assert_eq!(server.kept_files().len(), 1);
    assert_alive(&server).await;
}
