//! Raw bytes to a server and back, past any HTTP library.

use std::time::Duration;

use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::common::Server;

/// Longest that an answer is waited for.
const PATIENCE: Duration = Duration::from_secs(40);

/// A connection to the server.
pub async fn connect(server: &Server) -> TcpStream {
    let stream = TcpStream::connect(("127.0.0.1", server.port)).await;
    stream.expect("a connection")
}

/// Sends `bytes`, ends the sending side if requested, and reads all that comes back until the
/// server closes; empty when it resets the connection without a word.
pub async fn talk(server: &Server, bytes: &[u8], end: bool) -> String {
    let mut stream = connect(server).await;
    // The server may answer and close before all is sent.
    let _ = stream.write_all(bytes).await;
    if end {
        let _ = stream.shutdown().await;
    }
    rest(&mut stream).await
}

/// All that comes until the server closes.
pub async fn rest(stream: &mut TcpStream) -> String {
    let mut answer = Vec::new();
    let read = tokio::time::timeout(PATIENCE, stream.read_to_end(&mut answer)).await;
    let text = String::from_utf8_lossy(&answer).into_owned();
    assert!(read.is_ok(), "the server does not close after {text:?}");
    text
}

/// One answer, whole, however long the server keeps the connection open.
pub async fn answer(stream: &mut TcpStream) -> String {
    let mut text = String::new();
    let whole = |text: &str| {
        let (head, body) = text.split_once("\r\n\r\n")?;
        let head = head.to_ascii_lowercase();
        let length = head
            .lines()
            .find_map(|line| line.strip_prefix("content-length: "))?;
        Some(body.len() >= length.parse().ok()?)
    };
    let read = async {
        let mut piece = [0; 4096];
        while whole(&text) != Some(true) {
            let count = stream.read(&mut piece).await.expect("an answer");
            assert!(count > 0, "ends early: {text}");
            text += std::str::from_utf8(&piece[..count]).expect("text");
        }
    };
    tokio::time::timeout(PATIENCE, read)
        .await
        .expect("an answer in time");
    text
}

/// A GET request that asks for the connection to be closed.
pub fn get(path: &str, headers: &str) -> Vec<u8> {
    format!("GET {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n{headers}\r\n").into_bytes()
}

/// A POST request with a body in `headers`' framing, that asks for the connection to be closed.
pub fn post(path: &str, headers: &str, body: &[u8]) -> Vec<u8> {
    let head = format!("POST {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n{headers}\r\n");
    [head.as_bytes(), body].concat()
}

/// The status of the first answer in `text`; 0 when there is none.
pub fn status(text: &str) -> u16 {
    let line = text
        .strip_prefix("HTTP/1.1 ")
        .or(text.strip_prefix("HTTP/1.0 "));
    line.and_then(|line| line.get(..3)?.parse().ok())
        .unwrap_or(0)
}

/// Asserts that `answer` is one whole problem with this status, and gives it.
pub fn assert_problem(answer: &str, status: u16) -> Value {
    assert_eq!(self::status(answer), status, "{answer}");
    let (head, body) = answer.split_once("\r\n\r\n").expect("a head");
    let head = head.to_ascii_lowercase();
    assert!(
        head.contains("content-type: application/problem+json"),
        "{answer}"
    );
    let length = format!("content-length: {}", body.len());
    assert!(head.lines().any(|line| line == length), "{answer}");
    assert!(head.contains("x-content-type-options: nosniff"), "{answer}");
    let problem: Value = serde_json::from_str(body).expect("JSON");
    assert_eq!(problem["status"], status, "{answer}");
    assert!(
        problem["detail"]
            .as_str()
            .is_some_and(|text| !text.is_empty())
    );
    problem
}

/// Asserts that the server still answers.
pub async fn assert_alive(server: &Server) {
    let answer = talk(server, &get("/healthz", ""), false).await;
    assert_eq!(status(&answer), 200, "{answer}");
}
