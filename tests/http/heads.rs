//! Heads that no client should send, and odd ones that it may.

use tokio::io::AsyncWriteExt;

use crate::common::server;
use crate::raw::{assert_alive, assert_problem, connect, get, post, rest, status, talk};

#[tokio::test(flavor = "multi_thread")]
async fn malformed_heads_are_refused_with_a_problem() {
    let server = server().await;
    for (what, bytes) in [
        (
            "a folded line",
            "GET /healthz HTTP/1.1\r\nHost: x\r\nX-A: 1\r\n 2\r\n\r\n",
        ),
        (
            "a first line that is folded",
            "GET /healthz HTTP/1.1\r\n Host: x\r\n\r\n",
        ),
        (
            "a zero byte in a value",
            "GET /healthz HTTP/1.1\r\nHost: x\r\nX-A: a\0b\r\n\r\n",
        ),
        (
            "a zero byte in a name",
            "GET /healthz HTTP/1.1\r\nHost: x\r\nX\0A: a\r\n\r\n",
        ),
        (
            "a zero byte in the target",
            "GET /heal\0thz HTTP/1.1\r\nHost: x\r\n\r\n",
        ),
        (
            "a lone CR in a value",
            "GET /healthz HTTP/1.1\r\nHost: x\r\nX-A: a\rb\r\n\r\n",
        ),
        (
            "a space before the colon",
            "GET /healthz HTTP/1.1\r\nHost : x\r\n\r\n",
        ),
        ("no colon", "GET /healthz HTTP/1.1\r\nHost\r\n\r\n"),
        ("no target", "GET HTTP/1.1\r\nHost: x\r\n\r\n"),
        (
            "a space in the target",
            "GET /health z HTTP/1.1\r\nHost: x\r\n\r\n",
        ),
        (
            "a method that is no token",
            "GE(T /healthz HTTP/1.1\r\nHost: x\r\n\r\n",
        ),
        ("no version", "GET /healthz\r\nHost: x\r\n\r\n"),
        (
            "a version to come",
            "GET /healthz HTTP/9.9\r\nHost: x\r\n\r\n",
        ),
        (
            "version 2 in words of 1",
            "GET /healthz HTTP/2.0\r\nHost: x\r\n\r\n",
        ),
        ("another protocol", "SSH-2.0-OpenSSH_9.7\r\n\r\n"),
        (
            "a handshake of TLS",
            "\x16\x03\x01\x02\x00\x01\x00\x01\x7c\x03\x03",
        ),
        (
            "two hosts",
            "GET /healthz HTTP/1.1\r\nHost: x\r\nHost: y\r\nConnection: close\r\n\r\n",
        ),
        (
            "no host",
            "GET /healthz HTTP/1.1\r\nConnection: close\r\n\r\n",
        ),
    ] {
        let answer = talk(&server, bytes.as_bytes(), false).await;
        assert_eq!(status(&answer), 400, "{what}: {answer}");
        assert_problem(&answer, 400);
        assert_alive(&server).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn odd_heads_that_mean_something_are_understood() {
    let server = server().await;
    for (what, wanted, bytes) in [
        (
            "lines that end with LF alone",
            200,
            "GET /healthz HTTP/1.1\nHost: x\nConnection: close\n\n",
        ),
        (
            "empty lines before it",
            200,
            "\r\n\r\nGET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n",
        ),
        (
            "an absolute target",
            200,
            "GET http://x/healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n",
        ),
        ("version 1.0", 200, "GET /healthz HTTP/1.0\r\n\r\n"),
        (
            "a method in lower case",
            405,
            "get /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n",
        ),
        (
            "an absolute target that is not here",
            404,
            "GET http://x/nowhere HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n",
        ),
        (
            "a path without its slash",
            404,
            "GET healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n",
        ),
        (
            "the server as a whole",
            404,
            "OPTIONS * HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n",
        ),
        (
            "a tunnel",
            404,
            "CONNECT example.org:443 HTTP/1.1\r\nHost: example.org\r\nConnection: close\r\n\r\n",
        ),
        (
            "an upgrade",
            200,
            "GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: upgrade, close\r\nUpgrade: h2c\r\n\r\n",
        ),
    ] {
        let answer = talk(&server, bytes.as_bytes(), false).await;
        assert_eq!(status(&answer), wanted, "{what}: {answer}");
        if wanted != 200 {
            assert_problem(&answer, wanted);
        }
    }
    // Whoever speaks HTTP/2 from the start does not expect an answer in HTTP/1.
    let preface = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0";
    assert_eq!(talk(&server, preface, false).await, "");
    assert_alive(&server).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_method_is_answered_with_the_allowed_ones() {
    let server = server().await;
    for path in [
        "/",
        "/jobs",
        "/jobs/x",
        "/jobs/x/result",
        "/meshes",
        "/evaluations",
        "/healthz",
        "/openapi.json",
    ] {
        for method in ["TRACE", "PUT", "BREW", "PROPFIND"] {
            let request = format!(
                "{method} {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\nX-Secret: 1\r\n\r\n"
            );
            let answer = talk(&server, request.as_bytes(), false).await;
            assert_problem(&answer, 405);
            assert!(
                answer.to_ascii_lowercase().contains("\r\nallow: "),
                "{answer}"
            );
            assert!(!answer.contains("X-Secret"), "{answer}");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn no_path_leads_out_of_the_service() {
    let server = server().await;
    for path in [
        "/../../etc/passwd",
        "/jobs/../healthz",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/docs/../../etc/passwd",
        "/docs/..%2f..%2fCargo.toml",
        "/docs/%2e%2e/openapi.json",
        "/meshes/..%5c..%5cx",
        "/jobs/%00",
        "/jobs/%zz",
        "/jobs/%",
        "//healthz",
        "/healthz/",
        "/HEALTHZ",
        "/jobs/%ff%fe",
    ] {
        assert_problem(&talk(&server, &get(path, ""), false).await, 404);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn lengths_that_cannot_be_believed_are_refused() {
    let server = server().await;
    for headers in [
        "Content-Length: -5\r\n",
        "Content-Length: +5\r\n",
        "Content-Length: 0x5\r\n",
        "Content-Length: 5 5\r\n",
        "Content-Length: 5, 6\r\n",
        "Content-Length: \r\n",
        "Content-Length: 99999999999999999999999\r\n",
        "Content-Length: 5\r\nContent-Length: 6\r\n",
        "Transfer-Encoding: identity\r\n",
        "Transfer-Encoding: chunked, gzip\r\n",
        "Transfer-Encoding: xchunked\r\n",
        "Transfer-Encoding: \x0bchunked\r\n",
        "Content-Length: 5\r\nTransfer-Encoding: gzip\r\n",
    ] {
        let request = post(
            "/jobs",
            &format!("Content-Type: application/json\r\n{headers}"),
            b"hello",
        );
        let answer = talk(&server, &request, false).await;
        assert_eq!(status(&answer), 400, "{headers}: {answer}");
        assert_problem(&answer, 400);
    }
    for coding in [
        "gzip, chunked",
        "gzip\r\nTransfer-Encoding: chunked",
        "chunked\r\nTransfer-Encoding: chunked",
    ] {
        let headers = format!("Content-Type: application/json\r\nTransfer-Encoding: {coding}\r\n");
        let answer = talk(
            &server,
            &post("/jobs", &headers, b"2\r\n{}\r\n0\r\n\r\n"),
            false,
        )
        .await;
        assert_problem(&answer, 501);
    }
    let old = "POST /jobs HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n";
    assert_problem(&talk(&server, old.as_bytes(), false).await, 400);
    assert_alive(&server).await;
}

/// A server and a proxy before it must agree on where a request ends.
#[tokio::test(flavor = "multi_thread")]
async fn nothing_is_smuggled_behind_two_lengths() {
    let server = server().await;
    let hidden = "GET /meshes HTTP/1.1\r\nHost: x\r\n\r\n";
    let kind = "Content-Type: application/json";
    for lengths in [
        format!(
            "Content-Length: {}\r\nTransfer-Encoding: chunked",
            hidden.len() + 12
        ),
        format!(
            "Transfer-Encoding: chunked\r\nContent-Length: {}",
            hidden.len() + 12
        ),
    ] {
        let request = format!(
            "POST /jobs HTTP/1.1\r\nHost: x\r\n{kind}\r\n{lengths}\r\n\r\n2\r\n{{}}\r\n0\r\n\r\n{hidden}"
        );
        let answer = talk(&server, request.as_bytes(), false).await;
        assert_eq!(answer.matches("HTTP/1.1 ").count(), 1, "{answer}");
        assert_problem(&answer, 422);
    }
    // The same length twice is one length.
    let request = format!(
        "POST /jobs HTTP/1.1\r\nHost: x\r\n{kind}\r\nContent-Length: 2\r\nContent-Length: 2\r\n\r\n{{}}"
    );
    let mut stream = connect(&server).await;
    stream.write_all(request.as_bytes()).await.unwrap();
    stream.write_all(&get("/healthz", "")).await.unwrap();
    let answers = rest(&mut stream).await;
    assert_eq!(status(&answers), 422, "{answers}");
    assert!(answers.contains("HTTP/1.1 200 "), "{answers}");
}
