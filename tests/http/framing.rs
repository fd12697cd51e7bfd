//! What an HTTP library would not send: raw bytes on a socket.

use std::time::Duration;

use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::common::{server, small_box};
use crate::raw::{assert_problem, get, talk};

#[tokio::test(flavor = "multi_thread")]
async fn heads_that_are_too_large_are_refused() {
    let server = server().await;
    let path = format!("/{}", "a".repeat(9000));
    assert_problem(&talk(&server, &get(&path, ""), false).await, 414);
    let many: String = (0..101).map(|count| format!("x-{count}: 1\r\n")).collect();
    assert_problem(&talk(&server, &get("/healthz", &many), false).await, 431);
    let long = format!("x-long: {}\r\n", "a".repeat(17_000));
    assert_problem(&talk(&server, &get("/healthz", &long), false).await, 431);
    let absurd: String = (0..2000).map(|count| format!("x-{count}: 1\r\n")).collect();
    assert_problem(&talk(&server, &get("/healthz", &absurd), false).await, 431);
    let endless = format!("x-long: {}\r\n", "a".repeat(500_000));
    assert_problem(&talk(&server, &get("/healthz", &endless), false).await, 431);
    let path = format!("/{}", "a".repeat(100_000));
    assert_problem(&talk(&server, &get(&path, ""), false).await, 414);
    assert!(
        talk(&server, &get("/healthz", ""), false)
            .await
            .starts_with("HTTP/1.1 200 ")
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_body_shorter_than_declared_stores_nothing() {
    let server = server().await;
    let head = "POST /meshes?format=stl HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n\r\n";
    let bytes = [head.as_bytes(), &small_box()].concat();
    let answer = talk(&server, &bytes, true).await;
    assert!(
        answer.is_empty() || answer.starts_with("HTTP/1.1 400 "),
        "{answer}"
    );

    let part = "--b\r\nContent-Disposition: form-data; name=\"mesh\"; filename=\"a.stl\"\r\n\r\n";
    let head = "POST /jobs HTTP/1.1\r\nHost: x\r\nContent-Type: multipart/form-data; boundary=b\r\nContent-Length: 100000\r\n\r\n";
    let bytes = [head.as_bytes(), part.as_bytes(), &small_box()].concat();
    let answer = talk(&server, &bytes, true).await;
    assert!(
        answer.is_empty() || answer.starts_with("HTTP/1.1 400 "),
        "{answer}"
    );

    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(server.json("/meshes").await["meshes"], json!([]));
    assert_eq!(server.kept_files(), [""; 0]);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_upload_that_declares_too_much_is_refused_before_it_is_sent() {
    let server = server().await;
    let head = "POST /meshes?format=stl HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: 99999999999\r\nConnection: close\r\n\r\n";
    assert_problem(&talk(&server, head.as_bytes(), false).await, 413);
}

/// As many clients do: all is sent before anything is read.
#[tokio::test(flavor = "multi_thread")]
async fn an_early_answer_reaches_a_client_that_is_still_sending() {
    let server = server().await;
    for (line, status) in [
        ("POST /nowhere", 404),
        ("PUT /jobs", 405),
        ("POST /jobs?colour=red", 400),
        ("POST /jobs", 415),
    ] {
        let head = format!(
            "{line} HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Encoding: gzip\r\nContent-Length: 8000000\r\n\r\n"
        );
        let mut stream = TcpStream::connect(("127.0.0.1", server.port))
            .await
            .unwrap();
        stream.write_all(head.as_bytes()).await.unwrap();
        for _ in 0..80 {
            stream.write_all(&[b'x'; 100_000]).await.expect(line);
        }
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await.expect(line);
        assert_problem(&answer, status);
    }
}
