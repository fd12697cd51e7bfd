//! Idempotency-Key, priorities, expiry.

use std::time::Duration;

use reqwest::{Response, StatusCode};
use serde_json::{Value, json};

use crate::common::{Server, file, problem, server, server_with, small_box};

fn quick() -> Value {
    json!({"population": 20, "generations": 2, "candidates": "triangles"})
}

/// A request that nobody waits for.
fn endless() -> Value {
    json!({"population": 10_000, "generations": 90_000, "seed": 7})
}

async fn submit(server: &Server, key: &str, body: &Value) -> Response {
    let request = server
        .post("/jobs")
        .header("idempotency-key", key)
        .json(body);
    request.send().await.unwrap()
}

async fn id_of(answer: Response) -> String {
    assert_eq!(answer.status(), StatusCode::ACCEPTED);
    let location = answer.headers()["location"].to_str().unwrap().to_owned();
    let job: Value = answer.json().await.unwrap();
    assert_eq!(location, format!("/jobs/{}", job["id"].as_str().unwrap()));
    job["id"].as_str().unwrap().to_owned()
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_submission_makes_one_job_however_it_is_written() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let mut body = quick();
    body["mesh_id"] = mesh.as_str().into();
    let first = id_of(submit(&server, "k1", &body).await).await;
    // Other spacing and order, the key in quotation marks, and no seed in either: the same.
    let text = format!(
        "{{ \"candidates\": \"triangles\", \"generations\": 2.0,\n \"mesh_id\": \"{mesh}\", \"population\": 20}}"
    );
    let again = server
        .post("/jobs")
        .header("idempotency-key", "\"k1\"")
        .header("content-type", "application/json")
        .body(text);
    assert_eq!(id_of(again.send().await.unwrap()).await, first);
    server.wait_for(&first, &["succeeded"]).await;
    assert_eq!(id_of(submit(&server, "k1", &body).await).await, first);

    body["contacts"] = json!(5);
    let other = problem(submit(&server, "k1", &body).await, 422).await;
    assert_eq!(other["type"], "/problems/idempotency-key-reused");
    assert_ne!(id_of(submit(&server, "k2", &body).await).await, first);
    let list = server.json("/jobs").await;
    assert_eq!(list["jobs"].as_array().unwrap().len(), 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_form_sent_again_has_another_boundary_and_makes_no_second_job() {
    let server = server().await;
    let send = |bytes: Vec<u8>, seed: &'static str| {
        let form = file(bytes)
            .text("population", "20")
            .text("generations", "2")
            .text("seed", seed);
        server
            .post("/jobs")
            .header("idempotency-key", "upload")
            .multipart(form)
            .send()
    };
    let first = id_of(send(small_box(), "1").await.unwrap()).await;
    assert_eq!(id_of(send(small_box(), "1").await.unwrap()).await, first);
    problem(send(small_box(), "2").await.unwrap(), 422).await;
    let other = crate::common::cuboid([1.0, 2.0, 4.0], 4);
    problem(send(other, "1").await.unwrap(), 422).await;
    assert_eq!(server.kept_files().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_refused_submission_does_not_use_its_key_up() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    problem(
        submit(&server, "k", &json!({"mesh_id": mesh, "contacts": 65})).await,
        422,
    )
    .await;
    problem(
        submit(&server, "k", &json!({"mesh_id": "0".repeat(64)})).await,
        422,
    )
    .await;
    let mut body = quick();
    body["mesh_id"] = mesh.into();
    let job = id_of(submit(&server, "k", &body).await).await;
    server.wait_for(&job, &["succeeded"]).await;
    let path = format!("/jobs/{job}");
    assert_eq!(server.delete(&path).send().await.unwrap().status(), 204);
    problem(submit(&server, "k", &body).await, 410).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn malformed_keys_are_refused() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let mut body = quick();
    body["mesh_id"] = mesh.into();
    let long = "k".repeat(256);
    for bad in [
        "", "   ", "\"", "\"\"", "\"open", "a b", "a\"b", "a\\b", "\u{e9}", &long,
    ] {
        let problem = problem(submit(&server, bad, &body).await, 400).await;
        assert!(
            problem["detail"]
                .as_str()
                .unwrap()
                .contains("Idempotency-Key")
        );
    }
    let twice = server
        .post("/jobs")
        .header("idempotency-key", "a")
        .header("idempotency-key", "a");
    problem(twice.json(&body).send().await.unwrap(), 400).await;
    let fits = "k".repeat(255);
    id_of(submit(&server, &fits, &body).await).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_hundred_at_once_under_one_key_make_one_job() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let mut body = quick();
    body["mesh_id"] = mesh.into();
    let all = (0..100).map(|_| submit(&server, "same", &body));
    let mut ids = Vec::new();
    let mut in_flight = 0;
    for answer in futures_util::future::join_all(all).await {
        match answer.status() {
            StatusCode::ACCEPTED => ids.push(id_of(answer).await),
            _ => {
                assert!(answer.headers().contains_key("retry-after"));
                problem(answer, 409).await;
                in_flight += 1;
            }
        }
    }
    assert!(!ids.is_empty() && ids.iter().all(|id| *id == ids[0]));
    assert_eq!(ids.len() + in_flight, 100);
    assert_eq!(
        server.json("/jobs").await["jobs"].as_array().unwrap().len(),
        1
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn an_upload_under_way_holds_its_key() {
    let server = server().await;
    let (mut sender, receiver) = piecewise();
    let stream = reqwest::Body::wrap_stream(receiver);
    let slow = server
        .post("/jobs")
        .header("idempotency-key", "k")
        .header("content-type", "application/json")
        .body(stream);
    let slow = tokio::spawn(slow.send());
    sender.send(b"{\"mesh_id\": ").await;
    // Nobody else may come first: it has to be under way.
    let under_way = async || {
        let metrics = server.get("/metrics").send().await.unwrap();
        let metrics = metrics.text().await.unwrap();
        metrics.contains("graspd_http_requests_in_flight 2")
    };
    while !under_way().await {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let body = json!({"mesh_id": "0".repeat(64)});
    let refused = loop {
        let answer = submit(&server, "k", &body).await;
        if answer.status() == 409 {
            break answer;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    };
    assert_eq!(refused.headers()["retry-after"], "1");
    // A client that hangs up gives it back.
    drop(sender);
    slow.abort();
    for _ in 0..1000 {
        if submit(&server, "k", &body).await.status() == 422 {
            return;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("the key is still held");
}

/// The two ends of a body that is sent piece by piece.
fn piecewise() -> (
    Pieces,
    impl futures_util::Stream<Item = Result<Vec<u8>, std::io::Error>>,
) {
    let (sender, receiver) = tokio::sync::mpsc::channel(1);
    let stream = futures_util::stream::unfold(receiver, |mut receiver| async move {
        let piece: Option<Vec<u8>> = receiver.recv().await;
        piece.map(|piece| (Ok(piece), receiver))
    });
    (Pieces(sender), stream)
}

struct Pieces(tokio::sync::mpsc::Sender<Vec<u8>>);

impl Pieces {
    async fn send(&mut self, piece: &[u8]) {
        self.0.send(piece.to_vec()).await.unwrap();
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn interactive_jobs_overtake_batch_jobs_that_still_get_their_turn() {
    let server = server_with(&["--workers", "1"]).await;
    let mesh = server.mesh(small_box()).await;
    let blocker = server.job(&mesh, endless()).await;
    server.wait_for(&blocker, &["running"]).await;
    let mut jobs = Vec::new();
    for priority in ["batch", "interactive"] {
        for _ in 0..6 {
            let mut request = quick();
            request["priority"] = json!(priority);
            jobs.push((priority, server.job(&mesh, request).await));
        }
    }
    let cancelled = server
        .post(&format!("/jobs/{blocker}/cancel"))
        .send()
        .await
        .unwrap();
    assert_eq!(cancelled.status(), 202);
    let mut started = Vec::new();
    for (priority, job) in &jobs {
        let job = server.wait_for(job, &["succeeded"]).await;
        assert_eq!(job["priority"], *priority);
        started.push((job["started_at"].as_str().unwrap().to_owned(), *priority));
    }
    started.sort();
    let batch_among = |range: std::ops::Range<usize>| {
        started[range]
            .iter()
            .filter(|(_, priority)| *priority == "batch")
            .count()
    };
    assert!(batch_among(0..4) <= 1, "{started:?}");
    assert!((1..=2).contains(&batch_among(0..8)), "{started:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn expired_jobs_are_answered_410() {
    let server = server_with(&["--retention", "2s"]).await;
    let mesh = server.mesh(small_box()).await;
    let job = server.job(&mesh, quick()).await;
    server.wait_for(&job, &["succeeded"]).await;
    for _ in 0..200 {
        let answer = server.get(&format!("/jobs/{job}")).send().await.unwrap();
        if answer.status() != 200 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let paths = [
        "",
        "/result",
        "/grasp.glb",
        "/grasp.csv",
        "/grasp.isaac.yaml",
    ]
    .map(|resource| format!("/jobs/{job}{resource}"));
    for path in &paths {
        problem(server.get(path).send().await.unwrap(), 410).await;
    }
    problem(
        server
            .post(&format!("/jobs/{job}/cancel"))
            .send()
            .await
            .unwrap(),
        410,
    )
    .await;
    for _ in 0..200 {
        if server.kept_files().is_empty() {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert_eq!(server.kept_files(), [] as [String; 0]);
    problem(
        server.get(&format!("/meshes/{mesh}")).send().await.unwrap(),
        404,
    )
    .await;
}
