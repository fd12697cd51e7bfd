//! Many connections, idle ones, and several requests on one.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::time::{Duration, Instant};

use reqwest::Client;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};

use crate::common::{Server, server, server_with};
use crate::raw::{assert_alive, assert_problem, connect, rest, status};

/// A connection from another address of this machine.
async fn connect_from(last: u8, server: &Server) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    let from = SocketAddr::from((Ipv4Addr::new(127, 0, 0, last), 0));
    socket.bind(from).unwrap();
    let to = SocketAddr::from((Ipv4Addr::LOCALHOST, server.port));
    socket.connect(to).await.unwrap()
}

fn client_from(last: u8) -> Client {
    Client::builder()
        .no_proxy()
        .local_address(IpAddr::from([127, 0, 0, last]))
        .timeout(Duration::from_secs(20))
        .build()
        .unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_thousand_idle_connections_delay_nobody() {
    let server = server_with(&["--max-connections", "1200"]).await;
    rlimit::increase_nofile_limit(8192).unwrap();
    let mut idle = Vec::new();
    for count in 0..1000 {
        idle.push(connect_from(if count < 900 { 2 } else { 3 }, &server).await);
    }
    let client = client_from(4);
    for _ in 0..10 {
        let start = Instant::now();
        let answer = client.get(server.url("/healthz")).send().await.unwrap();
        assert_eq!(answer.status(), 200);
        assert!(start.elapsed() < Duration::from_secs(5));
    }
    // The first address has its three quarters; one more from it is refused.
    let mut more = connect_from(2, &server).await;
    let refused = rest(&mut more).await;
    assert_problem(&refused, 503);
    assert!(refused.contains("\r\nretry-after: "), "{refused}");
    // They do not hold up the end either.
    let start = Instant::now();
    server.stop().await;
    assert!(
        start.elapsed() < Duration::from_secs(7),
        "{:?}",
        start.elapsed()
    );
    drop(idle);
}

#[tokio::test(flavor = "multi_thread")]
async fn beyond_the_bound_connections_wait_for_a_place() {
    let server = server_with(&["--max-connections", "4"]).await;
    let mut held = Vec::new();
    for last in [2, 2, 2, 3] {
        held.push(connect_from(last, &server).await);
    }
    // Until all four are accepted, in their order.
    tokio::time::sleep(Duration::from_millis(300)).await;
    let client = client_from(4);
    let waiting = tokio::spawn(client.get(server.url("/healthz")).send());
    tokio::time::sleep(Duration::from_millis(500)).await;
    assert!(!waiting.is_finished());
    held.pop();
    assert_eq!(waiting.await.unwrap().unwrap().status(), 200);
}

#[tokio::test(flavor = "multi_thread")]
async fn requests_on_one_connection_are_answered_in_their_order() {
    let server = server().await;
    let mut stream = connect(&server).await;
    let lines = [
        ("/jobs", 200),
        ("/nowhere", 404),
        ("/healthz?x=1", 400),
        ("/meshes", 200),
        ("/jobs/x", 404),
        ("/healthz", 200),
    ];
    let requests: String = (0..20)
        .flat_map(|_| lines)
        .map(|(path, _)| format!("GET {path} HTTP/1.1\r\nHost: x\r\n\r\n"))
        .collect();
    stream.write_all(requests.as_bytes()).await.unwrap();
    stream.write_all(b"?? / HTTP/1.1\r\n\r\n").await.unwrap();
    let answers = rest(&mut stream).await;
    let found: Vec<u16> = answers
        .match_indices("HTTP/1.1 ")
        .map(|(at, _)| status(&answers[at..]))
        .collect();
    let wanted: Vec<u16> = (0..20)
        .flat_map(|_| lines)
        .map(|(_, status)| status)
        .collect();
    assert_eq!(found[..120], wanted);
    assert_eq!(found[120..], [400]);
    let last = answers.rfind("HTTP/1.1 ").unwrap();
    assert_problem(&answers[last..], 400);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_ends_its_side_gets_its_answer_or_nothing() {
    let server = server().await;
    let mut stream = connect(&server).await;
    stream
        .write_all(b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n")
        .await
        .unwrap();
    stream.shutdown().await.unwrap();
    let answer = rest(&mut stream).await;
    // The server cannot distinguish it from a client that has gone.
    assert!([200, 0].contains(&status(&answer)), "{answer}");
    for partial in ["GET /heal", "GET /healthz HTTP/1.1\r\nHos", ""] {
        let mut stream = connect(&server).await;
        stream.write_all(partial.as_bytes()).await.unwrap();
        stream.shutdown().await.unwrap();
        assert_eq!(rest(&mut stream).await, "", "{partial:?}");
    }
    assert_alive(&server).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_gets_100_continue_only_when_its_body_will_be_read() {
    let server = server().await;
    let head = "HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nContent-Length: 2\r\n";
    let mut stream = connect(&server).await;
    let wanted = format!("POST /jobs {head}Content-Type: application/json\r\n\r\n");
    stream.write_all(wanted.as_bytes()).await.unwrap();
    let mut leave = [0; 25];
    stream.read_exact(&mut leave).await.unwrap();
    assert_eq!(&leave, b"HTTP/1.1 100 Continue\r\n\r\n");
    stream.write_all(b"{}").await.unwrap();
    let mut answer = vec![0; 12];
    stream.read_exact(&mut answer).await.unwrap();
    assert_eq!(answer, b"HTTP/1.1 422");
    for (target, kind, refusal) in [
        ("/jobs?x=1", "application/json", 400),
        ("/jobs", "text/plain", 415),
        ("/nowhere", "application/json", 404),
    ] {
        let mut stream = connect(&server).await;
        let unwanted =
            format!("POST {target} {head}Connection: close\r\nContent-Type: {kind}\r\n\r\n");
        stream.write_all(unwanted.as_bytes()).await.unwrap();
        assert_problem(&rest(&mut stream).await, refusal);
    }
}
