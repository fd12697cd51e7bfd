//! The life of a job as Server-Sent Events.

use std::time::{Duration, Instant};

use reqwest::{RequestBuilder, Response, StatusCode};
use serde_json::json;
use testkit::events::Reader;

use crate::common::{Server, problem, small_box, start};
use crate::scripted::{runner, server};

/// Opens the stream of a job, from behind the event `seen` where given.
async fn open(server: &Server, job: &str, seen: Option<u64>) -> Reader {
    Reader::open(request(server, job, seen)).await
}

fn request(server: &Server, job: &str, seen: Option<u64>) -> RequestBuilder {
    let request = server.get(&format!("/jobs/{job}/events"));
    match seen {
        Some(seen) => request.header("last-event-id", seen),
        None => request,
    }
}

async fn ask(server: &Server, job: &str, seen: Option<u64>) -> Response {
    let answer = request(server, job, seen).send().await;
    answer.expect("an answer")
}

async fn cancel(server: &Server, job: &str) {
    let answer = server.post(&format!("/jobs/{job}/cancel")).send().await;
    assert!(answer.expect("an answer").status().is_success());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_is_followed_from_the_queue_to_its_end() {
    let (server, mesh) = server(&[]).await;
    let blocker = server.job(&mesh, json!({"label": "endless"})).await;
    server.wait_for(&blocker, &["running"]).await;
    let job = server.job(&mesh, json!({"label": "paced"})).await;
    let mut reader = open(&server, &job, None).await;
    let snapshot = reader.next().await.unwrap();
    assert_eq!(snapshot.name, "snapshot");
    assert!(snapshot.retry);
    assert_eq!(snapshot.data, server.json(&format!("/jobs/{job}")).await);
    assert_eq!(snapshot.data["state"], "queued");
    cancel(&server, &blocker).await;

    let mut last = snapshot.id.unwrap();
    assert_eq!(snapshot.data["revision"], last);
    let mut generations = Vec::new();
    let end = loop {
        let event = reader.next().await.unwrap();
        let id = event.id.unwrap();
        assert!(id > last, "{event:?} after {last}");
        assert_eq!(event.data["revision"], id);
        assert!(!event.retry);
        last = id;
        if event.name != "progress" {
            break event;
        }
        assert_eq!(event.data["state"], "running");
        generations.push(event.data["progress"]["generation"].as_u64().unwrap());
    };
    assert_eq!(end.name, "end");
    assert!(generations.len() > 3, "{generations:?}");
    assert!(generations.is_sorted());
    assert!(
        reader.next_of_all().await.is_none(),
        "nothing behind the end"
    );
    let mut job = server.json(&format!("/jobs/{job}")).await;
    let result = job.as_object_mut().unwrap().remove("result").unwrap();
    assert_eq!(result["generation"], 10);
    assert_eq!(end.data, job);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_reader_that_comes_back_gets_what_is_newer() {
    let (server, mesh) = server(&[]).await;
    let job = server.job(&mesh, json!({"label": "endless"})).await;
    let mut reader = open(&server, &job, None).await;
    let mut seen = 0;
    for _ in 0..5 {
        seen = reader.next().await.unwrap().id.unwrap();
    }
    drop(reader);
    let mut reader = open(&server, &job, Some(seen)).await;
    let event = reader.next().await.unwrap();
    assert_eq!(event.name, "progress");
    assert!(event.retry && event.id.unwrap() > seen);
    // A reader may name a later revision than the current one; it receives the next event.
    let mut ahead = open(&server, &job, Some(1 << 60)).await;
    assert_eq!(ahead.next().await.unwrap().name, "progress");
    cancel(&server, &job).await;
    for reader in [&mut reader, &mut ahead] {
        let mut event = reader.next().await.unwrap();
        while event.name == "progress" {
            event = reader.next().await.unwrap();
        }
        assert_eq!(event.name, "end");
        seen = event.id.unwrap();
    }

    let mut late = open(&server, &job, Some(seen - 1)).await;
    let end = late.next().await.unwrap();
    assert_eq!((end.name.as_str(), end.id), ("end", Some(seen)));
    assert!(late.next().await.is_none());
    let nothing = ask(&server, &job, Some(seen)).await;
    assert_eq!(nothing.status(), StatusCode::NO_CONTENT);
    let mut new = open(&server, &job, None).await;
    let snapshot = new.next().await.unwrap();
    assert_eq!((snapshot.name.as_str(), snapshot.id), ("snapshot", None));
    let end = new.next().await.unwrap();
    assert_eq!((end.name.as_str(), end.id), ("end", Some(seen)));
    assert_eq!(snapshot.data, end.data);
    assert!(new.next().await.is_none());
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_restart_ends_streams_and_is_bridged() {
    let (mut server, mesh) = server(&[]).await;
    let job = server.job(&mesh, json!({"label": "endless"})).await;
    let mut reader = open(&server, &job, None).await;
    let mut seen = 0;
    for _ in 0..8 {
        seen = reader.next().await.unwrap().id.unwrap();
    }
    server.begin_stop();
    while let Some(event) = reader.next().await {
        assert_eq!(event.name, "progress", "no end was made");
        seen = event.id.unwrap();
    }
    let folder = server.stop().await;

    let server = start(folder, &[], |_| {}, Some(runner())).await;
    let mut reader = open(&server, &job, Some(seen)).await;
    for _ in 0..4 {
        let event = reader.next().await.unwrap();
        assert_eq!(event.name, "progress");
        assert!(event.id.unwrap() > seen, "{event:?} after {seen}");
        seen = event.id.unwrap();
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn places_are_bounded_and_freed_by_those_who_hang_up() {
    let (server, mesh) = server(&[]).await;
    let running = server.job(&mesh, json!({"label": "endless"})).await;
    let waiting = server.job(&mesh, json!({"label": "endless"})).await;
    let mut readers = Vec::new();
    let refused = loop {
        let answer = ask(&server, &waiting, None).await;
        if answer.status() != StatusCode::OK {
            break answer;
        }
        readers.push(answer);
        assert!(readers.len() <= 300);
    };
    assert_eq!(readers.len(), 256);
    assert!(refused.headers().contains_key("retry-after"));
    problem(refused, 503).await;
    let refused = server.get(&format!("/jobs/{waiting}?wait=60")).send();
    problem(refused.await.unwrap(), 503).await;
    // Who does not wait is answered, and so is all else.
    assert_eq!(
        server.json(&format!("/jobs/{waiting}")).await["state"],
        "queued"
    );
    server.json("/healthz").await;
    let refused = server.delete(&format!("/jobs/{waiting}/events")).send();
    problem(refused.await.unwrap(), 405).await;

    drop(readers);
    let end = Instant::now() + Duration::from_secs(20);
    while ask(&server, &running, None).await.status() != StatusCode::OK {
        assert!(Instant::now() < end, "the places stay taken");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn events_that_cannot_be_followed_are_refused() {
    let (server, mesh) = server(&[]).await;
    let job = server.job(&mesh, json!({})).await;
    let path = format!("/jobs/{job}/events");
    let unknown = "/jobs/01890000-0000-7000-8000-000000000000/events";
    problem(server.get(unknown).send().await.unwrap(), 404).await;
    problem(server.get("/jobs/x/events").send().await.unwrap(), 404).await;
    for accept in ["application/json", "text/event-stream;q=0, */*"] {
        let answer = server.get(&path).header("accept", accept).send().await;
        problem(answer.unwrap(), 406).await;
    }
    for accept in ["text/event-stream", "text/*", "*/*"] {
        let answer = server.get(&path).header("accept", accept).send().await;
        assert_eq!(answer.unwrap().status(), StatusCode::OK, "{accept}");
    }
    for id in [
        "",
        "x",
        "-1",
        "+1",
        "1.5",
        "0x10",
        " 1 2",
        "\u{0664}",
        "9223372036854775808",
    ] {
        let answer = server.get(&path).header("last-event-id", id).send().await;
        problem(answer.unwrap(), 400).await;
    }
    let twice = server.get(&path).header("last-event-id", "1");
    let twice = twice.header("last-event-id", "2").send().await;
    problem(twice.unwrap(), 400).await;
    problem(
        server.get(&format!("{path}?since=1")).send().await.unwrap(),
        400,
    )
    .await;
    server.wait_for(&job, &["succeeded"]).await;
    let far = "9223372036854775807";
    let answer = server.get(&path).header("last-event-id", far).send().await;
    assert_eq!(answer.unwrap().status(), StatusCode::NO_CONTENT);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_stream_of_a_deleted_job_ends() {
    let (server, mesh) = server(&[]).await;
    let job = server.job(&mesh, json!({"label": "endless"})).await;
    let mut reader = open(&server, &job, None).await;
    let mut seen = reader.next().await.unwrap().id;
    let gone = server.delete(&format!("/jobs/{job}")).send().await;
    assert_eq!(gone.unwrap().status(), StatusCode::NO_CONTENT);
    while let Some(event) = reader.next().await {
        assert_eq!(event.name, "progress");
        seen = event.id;
    }
    problem(ask(&server, &job, seen).await, 404).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_quiet_stream_sends_comments() {
    let (server, mesh) = server(&[]).await;
    server.job(&mesh, json!({"label": "endless"})).await;
    let job = server.job(&mesh, json!({})).await;
    let mut reader = open(&server, &job, None).await;
    assert_eq!(reader.next_of_all().await.unwrap().name, "snapshot");
    // The reader waits for 30 s at most.
    assert_eq!(reader.next_of_all().await.unwrap().name, "");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn those_who_wait_never_keep_out_those_who_work() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(folder, &["--max-connections", "8"], |_| {}, Some(runner())).await;
    let mesh = server.mesh(small_box()).await;
    let job = server.job(&mesh, json!({"label": "endless"})).await;
    server.wait_for(&job, &["running"]).await;
    let events = format!("/jobs/{job}/events");
    let streams = [
        server.get(&events).send().await.unwrap(),
        server.get(&events).send().await.unwrap(),
    ];
    for path in [events.clone(), format!("/jobs/{job}?wait=5")] {
        let refused = server.get(&path).send().await.unwrap();
        assert!(refused.headers().contains_key("retry-after"));
        problem(refused, 503).await;
    }
    assert_eq!(
        server
            .get(&format!("/jobs/{job}"))
            .send()
            .await
            .unwrap()
            .status(),
        200
    );
    drop(streams);
    for _ in 0..500 {
        if server.get(&events).send().await.unwrap().status() == 200 {
            return;
        }
        tokio::time::sleep(std::time::Duration::from_millis(10)).await;
    }
    panic!("the places of those who hung up stay taken");
}
