//! Jobs: submit, list, read, result, cancel, forget.

use std::time::{Duration, Instant};

use reqwest::StatusCode;
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use crate::common::{Server, cuboid, file, problem, server, server_with, small_box};

/// A request that is planned in no time.
fn quick() -> Value {
    json!({"population": 20, "generations": 3, "seed": 7, "candidates": "triangles"})
}

/// A request that nobody waits for.
fn endless() -> Value {
    json!({"population": 10_000, "generations": 90_000, "seed": 7})
}

async fn result(server: &Server, job: &str) -> Vec<u8> {
    let answer = server
        .get(&format!("/jobs/{job}/result"))
        .send()
        .await
        .unwrap();
    assert_eq!(answer.status(), StatusCode::OK);
    answer.bytes().await.unwrap().to_vec()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_file_and_nothing_else_is_enough() {
    let server = server().await;
    let answer = server
        .post("/jobs")
        .multipart(file(small_box()))
        .send()
        .await
        .unwrap();
    assert_eq!(answer.status(), StatusCode::ACCEPTED);
    assert!(answer.headers().contains_key("retry-after"));
    let location = answer.headers()["location"].to_str().unwrap().to_owned();
    let job: Value = answer.json().await.unwrap();
    let id = job["id"].as_str().unwrap();
    assert_eq!(location, format!("/jobs/{id}"));
    assert_eq!(job["request"]["contacts"], 4);
    assert!(job["request"]["seed"].as_u64().unwrap() < 1 << 53);
    let done = server.wait_for(id, &["succeeded"]).await;
    assert_eq!(done["request"], job["request"]);
    let result: Value = serde_json::from_slice(&result(&server, id).await).unwrap();
    assert_eq!(result["force_closure"], true, "{result}");
    assert_eq!(result["contacts"].as_array().unwrap().len(), 4);
    assert_eq!(result["seed"], job["request"]["seed"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn every_way_to_ask_means_the_same() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let fields = [
        ("population", "20"),
        ("generations", "3"),
        ("seed", "7"),
        ("candidates", "triangles"),
    ];
    let simple = |form: Form| {
        fields
            .iter()
            .fold(form, |form, (name, value)| form.text(*name, *value))
    };
    let last = simple(Form::new()).part("mesh", Part::bytes(small_box()).file_name("x.stl"));
    let one = file(small_box()).part("request", Part::text(quick().to_string()));
    let mut requests = Vec::new();
    let mut ids = vec![server.job(&mesh, quick()).await];
    for form in [simple(file(small_box())), last, one] {
        let answer = server.post("/jobs").multipart(form).send().await.unwrap();
        assert_eq!(answer.status(), StatusCode::ACCEPTED);
        ids.push(
            answer.json::<Value>().await.unwrap()["id"]
                .as_str()
                .unwrap()
                .to_owned(),
        );
    }
    let mut results = Vec::new();
    for id in &ids {
        let job = server.wait_for(id, &["succeeded"]).await;
        assert_eq!(job["mesh_id"], mesh.as_str());
        requests.push(job["request"].clone());
        let mut result: Value = serde_json::from_slice(&result(&server, id).await).unwrap();
        drop_times(&mut result);
        results.push(result);
    }
    assert!(requests.iter().all(|request| *request == requests[0]));
    assert!(results.iter().all(|result| *result == results[0]));
}

/// Removes what may differ between two runs of one request.
fn drop_times(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.remove("elapsed_s");
            object.values_mut().for_each(drop_times);
        }
        Value::Array(items) => items.iter_mut().for_each(drop_times),
        _ => {}
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn no_force_closure_is_an_outcome_and_not_a_failure() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let mut request = quick();
    request["contacts"] = json!(2);
    request["contact_model"] = json!("frictionless");
    let job = server.job(&mesh, request).await;
    server.wait_for(&job, &["succeeded"]).await;
    let result: Value = serde_json::from_slice(&result(&server, &job).await).unwrap();
    assert_eq!(result["force_closure"], false);
    assert!(result["explanation"]["detail"].is_string(), "{result}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_is_there_when_the_job_has_ended_and_not_before() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let job = server.job(&mesh, endless()).await;
    let early = server
        .get(&format!("/jobs/{job}/result"))
        .send()
        .await
        .unwrap();
    assert!(early.headers().contains_key("retry-after"));
    problem(early, 409).await;
    let running = server.get(&format!("/jobs/{job}")).send().await.unwrap();
    assert!(running.headers().contains_key("retry-after"));
    let view = server.wait_for(&job, &["running"]).await;
    assert!(view.get("progress").is_some());

    let start = Instant::now();
    let cancelled = server
        .post(&format!("/jobs/{job}/cancel"))
        .send()
        .await
        .unwrap();
    assert_eq!(cancelled.status(), StatusCode::ACCEPTED);
    server.wait_for(&job, &["cancelled"]).await;
    assert!(
        start.elapsed() < Duration::from_secs(2),
        "{:?}",
        start.elapsed()
    );
    let again = server
        .post(&format!("/jobs/{job}/cancel"))
        .send()
        .await
        .unwrap();
    assert_eq!(again.status(), StatusCode::OK);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_ended_job_and_its_result_have_entity_tags() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let job = server.job(&mesh, quick()).await;
    server.wait_for(&job, &["succeeded"]).await;
    for path in [format!("/jobs/{job}"), format!("/jobs/{job}/result")] {
        let answer = server.get(&path).send().await.unwrap();
        assert!(!answer.headers().contains_key("retry-after"));
        let tag = answer.headers()["etag"].clone();
        let answer = server
            .get(&path)
            .header("if-none-match", tag)
            .send()
            .await
            .unwrap();
        assert_eq!(answer.status(), StatusCode::NOT_MODIFIED);
        let head = server.client.head(server.url(&path)).send().await.unwrap();
        assert_eq!(head.status(), StatusCode::OK);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn lists_filter_by_state_and_mesh_and_come_in_pages() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let other = server.mesh(cuboid([1.0, 1.0, 1.5], 3)).await;
    let mut ids = Vec::new();
    for _ in 0..3 {
        ids.push(server.job(&mesh, quick()).await);
    }
    let last = server.job(&other, endless()).await;
    for id in &ids {
        server.wait_for(id, &["succeeded"]).await;
    }
    server.wait_for(&last, &["running"]).await;
    let list = async |query: &str| -> Vec<String> {
        let page = server.json(&format!("/jobs?{query}")).await;
        let items = page["jobs"].as_array().unwrap();
        items
            .iter()
            .map(|item| item["id"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(list("state=running").await, std::slice::from_ref(&last));
    assert_eq!(
        list(&format!("mesh_id={other}")).await,
        std::slice::from_ref(&last)
    );
    ids.reverse();
    assert_eq!(list("state=succeeded").await, ids);
    let page = server.json("/jobs?limit=3").await;
    assert_eq!(page["jobs"][0]["id"], last.as_str());
    let rest = list(&format!(
        "limit=3&cursor={}",
        page["next_cursor"].as_str().unwrap()
    ))
    .await;
    assert_eq!(rest, ids[2..]);
    assert_eq!(
        server
            .delete(&format!("/jobs/{last}"))
            .send()
            .await
            .unwrap()
            .status(),
        204
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_is_deleted_and_its_mesh_only_then() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let job = server.job(&mesh, endless()).await;
    problem(
        server
            .delete(&format!("/meshes/{mesh}"))
            .send()
            .await
            .unwrap(),
        409,
    )
    .await;
    let gone = server.delete(&format!("/jobs/{job}")).send().await.unwrap();
    assert_eq!(gone.status(), StatusCode::NO_CONTENT);
    problem(
        server.get(&format!("/jobs/{job}")).send().await.unwrap(),
        404,
    )
    .await;
    problem(
        server.delete(&format!("/jobs/{job}")).send().await.unwrap(),
        404,
    )
    .await;
    let end = Instant::now() + Duration::from_secs(5);
    while server
        .delete(&format!("/meshes/{mesh}"))
        .send()
        .await
        .unwrap()
        .status()
        != 204
    {
        assert!(Instant::now() < end, "the mesh stays in use");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_full_queue_refuses_and_says_when_to_come_back() {
    let server = server_with(&["--queue-capacity", "2"]).await;
    let mesh = server.mesh(small_box()).await;
    let first = server.job(&mesh, endless()).await;
    server.wait_for(&first, &["running"]).await;
    let mut waiting = vec![
        server.job(&mesh, endless()).await,
        server.job(&mesh, endless()).await,
    ];
    let mut request = quick();
    request["mesh_id"] = mesh.into();
    let refused = server.post("/jobs").json(&request).send().await.unwrap();
    assert!(refused.headers().contains_key("retry-after"));
    problem(refused, 503).await;
    assert_eq!(server.get("/healthz").send().await.unwrap().status(), 200);
    waiting.push(first);
    for job in waiting {
        let cancelled = server
            .post(&format!("/jobs/{job}/cancel"))
            .send()
            .await
            .unwrap();
        assert!(cancelled.status().is_success());
        server.wait_for(&job, &["cancelled"]).await;
    }
}
