//! Answers that wait: `?wait=`.

use std::time::{Duration, Instant};

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::common::problem;
use crate::scripted::server;

#[tokio::test(flavor = "multi_thread")]
async fn the_end_of_a_job_is_answered_when_it_comes() {
    let (server, mesh) = server(&["--workers", "2"]).await;
    for part in ["", "/result"] {
        let job = server.job(&mesh, json!({"label": "endless"})).await;
        server.wait_for(&job, &["running"]).await;
        let waiting = server.get(&format!("/jobs/{job}{part}?wait=60")).send();
        let waiting = tokio::spawn(waiting);
        tokio::time::sleep(Duration::from_millis(200)).await;
        assert!(!waiting.is_finished(), "progress is no end");
        let clock = Instant::now();
        let cancelled = server.post(&format!("/jobs/{job}/cancel")).send().await;
        assert_eq!(cancelled.unwrap().status(), StatusCode::ACCEPTED);
        let answer = waiting.await.unwrap().unwrap();
        assert!(clock.elapsed() < Duration::from_secs(20));
        assert_eq!(answer.status(), StatusCode::OK);
        assert!(!answer.headers().contains_key("retry-after"));
        let view: Value = answer.json().await.unwrap();
        let result = if part.is_empty() {
            assert_eq!(view["state"], "cancelled");
            &view["result"]
        } else {
            &view
        };
        assert!(result["generation"].as_u64().unwrap() > 0, "{view}");
        // Now there is nothing to wait for.
        let clock = Instant::now();
        let again = server.get(&format!("/jobs/{job}{part}?wait=60")).send();
        assert_eq!(again.await.unwrap().status(), StatusCode::OK);
        assert!(clock.elapsed() < Duration::from_secs(20));
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_current_job_is_answered_when_the_time_is_over() {
    let (server, mesh) = server(&[]).await;
    let job = server.job(&mesh, json!({"label": "endless"})).await;
    let clock = Instant::now();
    let answer = server.get(&format!("/jobs/{job}?wait=0.5")).send().await;
    let answer = answer.unwrap();
    assert!(clock.elapsed() >= Duration::from_millis(500));
    assert!(answer.headers().contains_key("retry-after"));
    let view: Value = answer.json().await.unwrap();
    assert_eq!(view["state"], "running");
    assert!(
        view["progress"]["elapsed_s"].as_f64().unwrap() > 0.3,
        "{view}"
    );
    let early = server.get(&format!("/jobs/{job}/result?wait=0.1")).send();
    let early = early.await.unwrap();
    assert!(early.headers().contains_key("retry-after"));
    problem(early, 409).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_with_the_entity_tag_gets_any_change() {
    let (server, mesh) = server(&[]).await;
    let running = server.job(&mesh, json!({"label": "endless"})).await;
    let queued = server.job(&mesh, json!({"label": "endless"})).await;
    let ask = async |job: &str, wait: &str, tag: &str| {
        let request = server.get(&format!("/jobs/{job}?wait={wait}"));
        let answer = request.header("if-none-match", tag).send().await.unwrap();
        let tag = answer.headers()["etag"].to_str().unwrap().to_owned();
        (answer.status(), tag, answer.text().await.unwrap())
    };
    server.wait_for(&running, &["running"]).await;
    let (status, mut tag, _) = ask(&running, "60", "\"other\"").await;
    assert_eq!(status, StatusCode::OK, "what the client has is another");
    for _ in 0..5 {
        let (status, newer, view) = ask(&running, "60", &tag).await;
        assert_eq!(status, StatusCode::OK);
        assert_ne!(newer, tag);
        assert!(view.contains(r#""state":"running""#), "{view}");
        tag = newer;
    }
    // A job that waits does not change.
    let (_, tag, _) = ask(&queued, "0", "\"other\"").await;
    let clock = Instant::now();
    let (status, same, _) = ask(&queued, "0.3", &tag).await;
    assert_eq!((status, &same), (StatusCode::NOT_MODIFIED, &tag));
    assert!(clock.elapsed() >= Duration::from_millis(300));
    let cancelled = server.post(&format!("/jobs/{running}/cancel")).send();
    cancelled.await.unwrap();
    let (status, _, view) = ask(&queued, "60", &tag).await;
    assert_eq!(status, StatusCode::OK);
    assert!(view.contains(r#""state":"running""#), "{view}");
    let (status, ended, _) = ask(&running, "60", &tag).await;
    assert_eq!(status, StatusCode::OK);
    let (status, ..) = ask(&running, "60", &ended).await;
    assert_eq!(
        status,
        StatusCode::NOT_MODIFIED,
        "at once: nothing more comes"
    );
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn invalid_times_are_refused() {
    let (server, mesh) = server(&[]).await;
    let job = server.job(&mesh, json!({})).await;
    for wait in [
        "-1", "61", "60.001", "NaN", "inf", "", "1s", "1&wait=2", "1,5",
    ] {
        for part in ["", "/result"] {
            let answer = server.get(&format!("/jobs/{job}{part}?wait={wait}")).send();
            problem(answer.await.unwrap(), 400).await;
        }
    }
    for wait in ["0", "0.0", ".5", "60", "6e1"] {
        let answer = server.get(&format!("/jobs/{job}?wait={wait}")).send();
        assert_eq!(answer.await.unwrap().status(), StatusCode::OK, "{wait}");
    }
    let unknown = server.get("/jobs/01890000-0000-7000-8000-000000000000?wait=60");
    problem(unknown.send().await.unwrap(), 404).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_deleted_job_and_a_shutdown_end_the_wait() {
    let (mut server, mesh) = server(&[]).await;
    let first = server.job(&mesh, json!({"label": "endless"})).await;
    let second = server.job(&mesh, json!({"label": "endless"})).await;
    let wait = |job: &str| tokio::spawn(server.get(&format!("/jobs/{job}?wait=60")).send());
    let (on_first, on_second) = (wait(&first), wait(&second));
    tokio::time::sleep(Duration::from_millis(200)).await;
    let clock = Instant::now();
    let gone = server.delete(&format!("/jobs/{first}")).send().await;
    assert_eq!(gone.unwrap().status(), StatusCode::NO_CONTENT);
    problem(on_first.await.unwrap().unwrap(), 404).await;
    assert!(!on_second.is_finished());
    server.begin_stop();
    let answer = on_second.await.unwrap().unwrap();
    assert_eq!(answer.status(), StatusCode::OK);
    let view: Value = answer.json().await.unwrap();
    assert!(["queued", "running"].contains(&view["state"].as_str().unwrap()));
    assert!(clock.elapsed() < Duration::from_secs(20));
    server.stop().await;
}
