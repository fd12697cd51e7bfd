//! What the server logs, and what it never does.

use std::fs::File;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use reqwest::Client;
use serde_json::Value;
use testkit::process::{Graspd, get, graspd};

use crate::common::{file, small_box};

/// Does a bit of everything with a server that logs in `format`, and gives the lines and the job.
async fn lines(format: &str) -> (Vec<String>, Value) {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log");
    let mut command: Command =
        graspd(&["serve", "--listen", "127.0.0.1:0", "--log-format", format]);
    command.arg("--data-dir").arg(folder.path().join("data"));
    command.stderr(Stdio::from(File::create(&log).unwrap()));
    let mut server = Graspd::launch(&mut command);
    let client = Client::builder().no_proxy().build().unwrap();
    let form = file(small_box())
        .text("population", "20")
        .text("generations", "3")
        .text("label", "label-in-the-body");
    let sent = client
        .post(server.url("/jobs?"))
        .header("x-request-id", "a-request-of-mine")
        .header("authorization", "Bearer secret-in-a-header")
        .multipart(form)
        .send();
    let job: Value = sent.await.unwrap().json().await.unwrap();
    let path = format!("/jobs/{}", job["id"].as_str().unwrap());
    let end = Instant::now() + Duration::from_secs(60);
    while get(&client, server.url(&path)).await["state"] != "succeeded" {
        assert!(Instant::now() < end);
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let address = server.url.trim_start_matches("http://").to_owned();
    for path in [
        "/%0d%0aforged%1b[31m",
        "/\u{202e}forged",
        "/\u{85}forged",
        "/\"},{\"forged\":\"",
        "/\rforged",
        "/\x1b[31mforged",
        "/?secret-in-a-query=1",
    ] {
        let mut stream = TcpStream::connect(&address).unwrap();
        let head = format!(
            "GET {path} HTTP/1.1\r\nHost: x\r\nX-Request-Id: a\tb\r\nConnection: close\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
    }
    assert!(server.signal("-TERM").success());
    let text = String::from_utf8(std::fs::read(log).unwrap()).unwrap();
    assert!(!text.contains("secret-in"), "{text}");
    assert!(!text.contains("label-in"), "{text}");
    let odd = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
    if format == "text" {
        assert!(!text.contains(odd), "{text:?}");
    }
    (text.lines().map(str::to_owned).collect(), job)
}

#[tokio::test(flavor = "multi_thread")]
async fn json_lines_name_request_job_and_mesh() {
    let (lines, job) = lines("json").await;
    let lines: Vec<Value> = lines
        .iter()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}")))
        .collect();
    for line in &lines {
        for member in ["timestamp", "level", "target", "message"] {
            assert!(line[member].is_string(), "{line}");
        }
        assert!(line.get("forged").is_none(), "{line}");
    }
    let find = |message: &str, member: &str, value: &Value| {
        let found = lines
            .iter()
            .find(|line| line["message"] == message && line[member] == *value);
        found.unwrap_or_else(|| panic!("no {message}: {lines:#?}"))
    };
    let request = Value::from("a-request-of-mine");
    let answered = find("answered", "request_id", &request);
    assert_eq!(answered["method"], "POST");
    assert_eq!(answered["path"], "/jobs");
    assert_eq!(answered["status"], 202);
    // The one line that ties a request to its job.
    let queued = find("job queued", "request_id", &request);
    assert_eq!(queued["job"], job["id"]);
    assert_eq!(queued["mesh"], job["mesh_id"]);
    for message in ["job starts", "job leaves its worker"] {
        let line = find(message, "job", &job["id"]);
        assert_eq!(line["mesh"], job["mesh_id"]);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_line_of_text_is_one_line() {
    let (lines, _) = lines("text").await;
    for line in &lines {
        let time = line.split(' ').next().unwrap();
        assert!(time.ends_with('Z') && time.contains('T'), "{line}");
    }
    assert!(
        lines
            .iter()
            .any(|line| line.contains("request_id=\"a-request-of-mine\""))
    );
}
