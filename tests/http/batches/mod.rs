//! Batches: many jobs as one.

use std::collections::HashSet;
use std::time::{Duration, Instant};

use graspd::store::Keys as _;
use graspd::store::sqlite::SqliteKeys;
use reqwest::{Response, StatusCode};
use serde_json::{Value, json};

use crate::common::{Server, cuboid, pointers, problem, server_with, small_box};
use crate::scripted::{self, server};

mod life;
mod refused;
mod taken;

async fn submit(server: &Server, body: &Value) -> Response {
    server.post("/batches").json(body).send().await.unwrap()
}

/// Submits a batch that is taken, and gives its id.
async fn submitted(server: &Server, body: Value) -> String {
    let answer = submit(server, &body).await;
    let status = answer.status();
    let location = answer.headers().get("location").cloned();
    let batch: Value = answer.json().await.unwrap();
    assert_eq!(status, StatusCode::ACCEPTED, "{batch}");
    let id = batch["id"].as_str().unwrap();
    assert_eq!(location.unwrap(), format!("/batches/{id}"));
    id.to_owned()
}

/// The batch once it has ended.
async fn ended(server: &Server, id: &str) -> Value {
    let batch = server.json(&format!("/batches/{id}?wait=60")).await;
    assert_eq!(batch["state"], "ended", "{batch}");
    batch
}

/// Asks for a batch and for its results, neither of which is there.
async fn is_gone(server: &Server, path: &str, status: u16) {
    for resource in ["", "/results"] {
        let answer = server.get(&format!("{path}{resource}")).send().await;
        problem(answer.unwrap(), status).await;
    }
}

/// The lines of a body, each of which has to be whole.
fn lines(text: &str) -> Vec<Value> {
    assert!(text.is_empty() || text.ends_with('\n'), "{text}");
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

async fn results(server: &Server, id: &str, query: &str) -> Vec<Value> {
    let answer = server.get(&format!("/batches/{id}/results{query}")).send();
    let answer = answer.await.unwrap();
    assert_eq!(answer.status(), StatusCode::OK);
    assert_eq!(answer.headers()["content-type"], "application/x-ndjson");
    lines(&answer.text().await.unwrap())
}

/// The places of the jobs in these lines.
fn places(lines: &[Value]) -> Vec<u64> {
    lines
        .iter()
        .map(|line| line["index"].as_u64().unwrap())
        .collect()
}

async fn jobs(server: &Server, query: &str) -> Vec<Value> {
    let page = server.json(&format!("/jobs?limit=1000{query}")).await;
    page["jobs"].as_array().unwrap().clone()
}
