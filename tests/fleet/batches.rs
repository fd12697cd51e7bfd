//! Batches of a fleet: submitted here, watched there, stopped from anywhere.

use reqwest::Method;
use serde_json::{Value, json};

use crate::fleet::Fleet;

async fn submitted(fleet: &Fleet, server: usize, body: Value) -> String {
    let post = fleet.request(server, Method::POST, "/batches").json(&body);
    let (status, batch) = fleet.answer(post).await;
    assert_eq!(status, 202, "{batch}");
    format!("/batches/{}", batch["id"].as_str().unwrap())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_is_planned_by_all_and_reported_by_each() {
    let mut fleet = Fleet::start(2, &[]);
    let mesh = fleet.small_box(0).await;
    let quick = json!({"population": 20, "generations": 2, "candidates": "triangles"});
    let path = submitted(
        &fleet,
        0,
        json!({"meshes": vec![&mesh; 60], "request": quick}),
    )
    .await;
    let waiting = fleet.request(1, Method::GET, &format!("{path}?wait=60"));
    let waiting = tokio::spawn(waiting.send());
    fleet.hire();
    fleet.hire();
    let batch: Value = waiting.await.unwrap().unwrap().json().await.unwrap();
    assert_eq!(
        (&batch["state"], &batch["jobs"]["succeeded"]),
        (&json!("ended"), &json!(60))
    );
    let mut answers = Vec::new();
    for server in [0, 1] {
        let lines = fleet.request(server, Method::GET, &format!("{path}/results"));
        answers.push(lines.send().await.unwrap().text().await.unwrap());
    }
    assert_eq!(answers[0], answers[1]);
    let lines = answers[0]
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap());
    for (index, line) in lines.enumerate() {
        assert_eq!(line["index"], index);
        let job = fleet.view(1, line["job_id"].as_str().unwrap()).await;
        assert_eq!(
            (&job["result"], &job["batch_index"]),
            (&line["result"], &line["index"])
        );
    }
    fleet.stop();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_is_stopped_and_forgotten_from_another_server() {
    let mut fleet = Fleet::start(2, &[]);
    let mesh = fleet.small_box(0).await;
    let long = json!({"population": 10_000, "generations": 90_000});
    for method in [Method::POST, Method::DELETE] {
        let body = json!({"meshes": vec![&mesh; 5], "request": long});
        let path = submitted(&fleet, 0, body).await;
        if fleet.workers.is_empty() {
            fleet.hire();
        }
        let of = path.replace("/batches/", "/jobs?state=running&batch_id=");
        let running = loop {
            let (_, page) = fleet.answer(fleet.request(0, Method::GET, &of)).await;
            if let Some(job) = page["jobs"].get(0) {
                break job["id"].as_str().unwrap().to_owned();
            }
            tokio::time::sleep(std::time::Duration::from_millis(50)).await;
        };
        if method == Method::POST {
            let cancel = fleet.request(1, Method::POST, &format!("{path}/cancel"));
            assert_eq!(fleet.answer(cancel).await.0, 202);
            let wait = fleet.request(0, Method::GET, &format!("{path}?wait=60"));
            let (_, batch) = fleet.answer(wait).await;
            assert_eq!(batch["jobs"]["cancelled"], 5, "{batch}");
        } else {
            let forget = fleet.request(1, Method::DELETE, &path);
            assert_eq!(fleet.answer(forget).await.0, 204);
            let gone = fleet.request(0, Method::GET, &path);
            assert_eq!(fleet.answer(gone).await.0, 404);
            let gone = fleet.request(0, Method::GET, &format!("/jobs/{running}"));
            assert_eq!(fleet.answer(gone).await.0, 404);
        }
    }
    // The worker is free for others.
    let job = fleet
        .job(
            1,
            &json!({"mesh_id": mesh, "generations": 1, "population": 5}),
        )
        .await;
    fleet.wait_for(0, &job, &["succeeded"]).await;
    fleet.stop();
}
