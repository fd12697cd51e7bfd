//! Traces, as a collector receives them.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::process::Stdio;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use reqwest::Client;
use testkit::process::{Graspd, graspd};

use crate::common::{file, small_box};

/// Takes every request and keeps its bytes.
fn collector() -> (String, Arc<Mutex<Vec<u8>>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let received = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&received);
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            stream
                .set_read_timeout(Some(Duration::from_millis(200)))
                .unwrap();
            let mut bytes = Vec::new();
            let _ = stream.read_to_end(&mut bytes);
            kept.lock().unwrap().extend(bytes);
            let _ = stream
                .write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
        }
    });
    (address, received)
}

#[tokio::test(flavor = "multi_thread")]
async fn requests_and_runs_are_spans_of_the_trace_they_belong_to() {
    let (address, received) = collector();
    let folder = tempfile::tempdir().unwrap();
    let mut command = graspd(&["serve", "--listen", "127.0.0.1:0", "--data-dir"]);
    command
        .arg(folder.path())
        .env("OTEL_EXPORTER_OTLP_ENDPOINT", format!("http://{address}"))
        .env("OTEL_BSP_SCHEDULE_DELAY", "100")
        .stderr(Stdio::null());
    let server = Graspd::launch(&mut command);
    let client = Client::builder().no_proxy().build().unwrap();
    let form = file(small_box())
        .text("population", "20")
        .text("generations", "3");
    let sent = client
        .post(server.url("/jobs"))
        .header(
            "traceparent",
            "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01",
        )
        .multipart(form)
        .send();
    assert_eq!(sent.await.unwrap().status(), 202);
    // As protobuf has them: ids in bytes, names in length and text.
    let trace: Vec<u8> = vec![
        0x0a, 0xf7, 0x65, 0x19, 0x16, 0xcd, 0x43, 0xdd, 0x84, 0x48, 0xeb, 0x21, 0x1c, 0x80, 0x31,
        0x9c,
    ];
    let wanted: [&[u8]; 6] = [
        b"POST /v1/traces",
        &trace,
        b"\x07request",
        b"\x03run",
        b"graspd",
        b"/jobs",
    ];
    let has = |bytes: &[u8], part: &[u8]| bytes.windows(part.len()).any(|window| window == part);
    let end = Instant::now() + Duration::from_secs(30);
    while !wanted
        .iter()
        .all(|part| has(&received.lock().unwrap(), part))
    {
        let text = String::from_utf8_lossy(&received.lock().unwrap()).into_owned();
        assert!(Instant::now() < end, "{text:?}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}
