//! SIGTERM while clients hold on to the server in every way.

use std::time::{Duration, Instant};

use reqwest::Client;
use testkit::process::Graspd;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

use crate::common::{file, small_box};

#[tokio::test(flavor = "multi_thread")]
async fn nothing_that_clients_do_holds_up_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Graspd::start(folder.path());
    let client = Client::builder().no_proxy().build().unwrap();
    let form = file(small_box())
        .text("population", "10000")
        .text("generations", "90000");
    let jobs = format!("{}/jobs", server.url);
    let answer = client.post(&jobs).multipart(form).send().await.unwrap();
    assert_eq!(answer.status(), 202);

    let address = server.url.strip_prefix("http://").unwrap().to_owned();
    let starts = [
        "",
        "GET /heal",
        "GET /healthz HTTP/1.1\r\nHost: x\r\n",
        "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n",
        "POST /meshes?format=stl HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000\r\n\r\nsolid",
        "POST /jobs HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n1\r\n{\r\n",
    ];
    let mut held = Vec::new();
    for start in starts.iter().cycle().take(60) {
        let mut stream = TcpStream::connect(&address).await.unwrap();
        stream.write_all(start.as_bytes()).await.unwrap();
        held.push(stream);
    }
    // The last ones keep on sending.
    let mut dribbling: Vec<TcpStream> = held.drain(54..).collect();
    let dribble = tokio::spawn(async move {
        loop {
            for stream in &mut dribbling {
                let _ = stream.write_all(b"1").await;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    });
    tokio::time::sleep(Duration::from_millis(300)).await;
    let start = Instant::now();
    let status = tokio::task::spawn_blocking(move || server.signal("-TERM")).await;
    assert!(status.unwrap().success());
    assert!(
        start.elapsed() < Duration::from_secs(25),
        "{:?}",
        start.elapsed()
    );
    dribble.abort();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_draining_server_reports_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Graspd::start(folder.path());
    let client = Client::builder().no_proxy().build().unwrap();
    let address = server.url.strip_prefix("http://").unwrap().to_owned();
    // Half a request keeps it from its end.
    let mut half = TcpStream::connect(&address).await.unwrap();
    let head = "POST /meshes HTTP/1.1\r\nhost: x\r\ncontent-type: model/stl\r\ncontent-length: 1000\r\n\r\nsolid";
    half.write_all(head.as_bytes()).await.unwrap();
    tokio::time::sleep(Duration::from_millis(300)).await;
    server.send("-TERM");
    tokio::time::sleep(Duration::from_millis(500)).await;
    for path in ["/readyz", "/meshes"] {
        let url = format!("{}{path}", server.url);
        let answer = match path {
            "/readyz" => client.get(url),
            _ => client
                .post(url)
                .header("content-type", "model/stl")
                .body("solid"),
        };
        let answer = answer.send().await.unwrap();
        assert!(answer.headers().contains_key("retry-after"), "{path}");
        let problem = crate::common::problem(answer, 503).await;
        assert_eq!(problem["type"], "/problems/draining");
    }
    let list = client
        .get(format!("{}/jobs", server.url))
        .send()
        .await
        .unwrap();
    assert_eq!(list.status(), 200);
    drop(half);
    assert!(server.signal("-TERM").success());
}
