//! Bodies in broken or absurd framing.

use serde_json::json;
use tokio::io::AsyncWriteExt;

use crate::common::{server, server_with, small_box};
use crate::raw::{answer, assert_alive, assert_problem, connect, get, post, status, talk};

const CHUNKED: &str = "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n";

#[tokio::test(flavor = "multi_thread")]
async fn broken_chunks_are_refused() {
    let server = server().await;
    let extension = format!("2;{}\r\n{{}}\r\n0\r\n\r\n", "x".repeat(200_000));
    let trailers = format!("2\r\n{{}}\r\n0\r\n{}\r\n", "x: 1\r\n".repeat(50_000));
    for (what, body) in [
        ("no number", "zz\r\n{}\r\n0\r\n\r\n"),
        ("a negative one", "-2\r\n{}\r\n0\r\n\r\n"),
        ("a prefix", "0x2\r\n{}\r\n0\r\n\r\n"),
        ("more than there is", "fffffffffffffffff\r\n{}\r\n0\r\n\r\n"),
        ("an empty line", "\r\n{}\r\n0\r\n\r\n"),
        ("longer than it says", "1\r\n{}\r\n0\r\n\r\n"),
        ("no line behind the data", "2\r\n{}0\r\n\r\n"),
        ("an endless extension", extension.as_str()),
        ("endless trailers", trailers.as_str()),
    ] {
        let answer = talk(&server, &post("/jobs", CHUNKED, body.as_bytes()), false).await;
        assert_eq!(status(&answer), 400, "{what}: {answer}");
        assert_problem(&answer, 400);
    }
    assert_alive(&server).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn chunks_may_have_extensions_and_trailers() {
    let server = server().await;
    for body in [
        "2;a=b;c=\"d\"\r\n{}\r\n0\r\n\r\n",
        "1\r\n{\r\n1\r\n}\r\n0\r\nX-Checksum: 1\r\nContent-Length: 7\r\n\r\n",
        "000002\r\n{}\r\n00\r\n\r\n",
    ] {
        // No mesh_id: it has been read to its end.
        let answer = talk(&server, &post("/jobs", CHUNKED, body.as_bytes()), false).await;
        assert_problem(&answer, 422);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_body_that_breaks_off_stores_nothing() {
    let server = server().await;
    let mesh = small_box();
    let half = &mesh[..mesh.len() / 2];
    let chunk = [format!("{:x}\r\n", half.len()).as_bytes(), half, b"\r\n"].concat();
    for (headers, body) in [
        (
            "Content-Type: model/stl\r\nTransfer-Encoding: chunked\r\n",
            chunk,
        ),
        (
            "Content-Type: model/stl\r\nContent-Length: 9684\r\n",
            half.to_vec(),
        ),
    ] {
        let answer = talk(&server, &post("/meshes", headers, &body), true).await;
        if !answer.is_empty() {
            assert_problem(&answer, 400);
        }
    }
    // A whole request with half a form in it.
    let form =
        b"--b\r\nContent-Disposition: form-data; name=\"mesh\"; filename=\"a.stl\"\r\n\r\nsolid";
    let headers = format!(
        "Content-Type: multipart/form-data; boundary=b\r\nContent-Length: {}\r\n",
        form.len()
    );
    for path in ["/jobs", "/meshes", "/evaluations"] {
        assert_problem(
            &talk(&server, &post(path, &headers, form), false).await,
            400,
        );
    }
    tokio::time::sleep(std::time::Duration::from_millis(200)).await;
    assert_eq!(server.json("/meshes").await["meshes"], json!([]));
    assert_eq!(server.kept_files(), [""; 0]);
}

#[tokio::test(flavor = "multi_thread")]
async fn too_much_is_refused_at_the_first_byte_too_many() {
    let server = server_with(&["--max-upload-bytes", "10000"]).await;
    // Each head is sent alone: the answer must not wait for the body.
    for (path, kind, length) in [
        ("/meshes", "model/stl", 10_001_u64),
        ("/jobs", "application/json", 65_537),
        ("/jobs", "multipart/form-data; boundary=b", 10_000_000),
        ("/evaluations", "application/json", 8 * 1024 * 1024 + 1),
        ("/meshes", "model/stl", u64::MAX - 10),
    ] {
        let headers = format!("Content-Type: {kind}\r\nContent-Length: {length}\r\n");
        let mut stream = connect(&server).await;
        stream.write_all(&post(path, &headers, b"")).await.unwrap();
        assert_problem(&answer(&mut stream).await, 413);
    }
    // The last chunk of each brings the first byte too many; the body never ends.
    for (path, kind, limit) in [
        ("/meshes", "model/stl", 10_000),
        ("/jobs", "application/json", 65_536),
    ] {
        let mut stream = connect(&server).await;
        let headers = format!("Content-Type: {kind}\r\nTransfer-Encoding: chunked\r\n");
        stream.write_all(&post(path, &headers, b"")).await.unwrap();
        let all = format!("{limit:x}\r\n{}\r\n1\r\n1\r\n", " ".repeat(limit));
        stream.write_all(all.as_bytes()).await.unwrap();
        assert_problem(&answer(&mut stream).await, 413);
    }
    assert_eq!(server.kept_files(), [""; 0]);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_next_request_begins_where_a_body_ends() {
    let server = server().await;
    let mesh = small_box();
    let upload = format!(
        "POST /meshes HTTP/1.1\r\nHost: x\r\nContent-Type: model/stl\r\nContent-Length: {}\r\n\r\n",
        mesh.len()
    );
    let all = [
        upload.as_bytes(),
        &mesh,
        upload.as_bytes(),
        &mesh,
        &get("/healthz", ""),
    ]
    .concat();
    let answers = talk(&server, &all, false).await;
    let found: Vec<u16> = answers
        .match_indices("HTTP/1.1 ")
        .map(|(at, _)| status(&answers[at..]))
        .collect();
    assert_eq!(found, [201, 200, 200], "{answers}");
}
