//! Batches: many jobs as one.

use std::collections::HashSet;
use std::time::{Duration, Instant};

use graspd::store::Keys as _;
use graspd::store::sqlite::SqliteKeys;
use reqwest::{Response, StatusCode};
use serde_json::{Value, json};

use crate::common::{Server, cuboid, pointers, problem, server_with, small_box};
use crate::scripted::{self, server};

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

#[tokio::test(flavor = "multi_thread")]
async fn many_meshes_are_planned_with_one_request() {
    let server = server_with(&["--workers", "2"]).await;
    let mut meshes = Vec::new();
    for size in 0..4 {
        let sides = [1.0 + size as f32, 2.0, 3.0];
        meshes.push(server.mesh(cuboid(sides, 4)).await);
    }
    meshes.push(meshes[0].clone());
    let request = json!({"population": 20, "generations": 2, "candidates": "triangles"});
    let body = json!({"meshes": meshes, "request": request, "label": "boxes"});
    let id = submitted(&server, body).await;
    let batch = ended(&server, &id).await;
    assert_eq!(
        (&batch["jobs"]["total"], &batch["jobs"]["succeeded"]),
        (&json!(5), &json!(5))
    );
    assert_eq!(batch["label"], "boxes");
    for time in ["created_at", "started_at", "finished_at"] {
        assert!(batch[time].is_string(), "{batch}");
    }
    let lines = results(&server, &id, "").await;
    assert_eq!(places(&lines), [0, 1, 2, 3, 4]);
    let mut seeds = HashSet::new();
    for (line, mesh) in lines.iter().zip(&meshes) {
        let job = line["job_id"].as_str().unwrap();
        let view = server.json(&format!("/jobs/{job}")).await;
        assert_eq!(
            (&view["batch_id"], &view["batch_index"]),
            (&json!(id), &line["index"])
        );
        assert_eq!(
            (&view["priority"], &view["mesh_id"]),
            (&json!("batch"), &json!(mesh))
        );
        assert_eq!(
            (&line["mesh_id"], &line["state"]),
            (&view["mesh_id"], &view["state"])
        );
        assert_eq!(line["result"], view["result"]);
        assert_eq!(line["result"]["seed"], view["request"]["seed"]);
        seeds.insert(view["request"]["seed"].as_u64().unwrap());
    }
    assert_eq!(seeds.len(), 5, "each has a seed of its own");
    // What is the same in all, planned alone with its seed, comes to the same.
    let mut alone = request.clone();
    alone["seed"] = lines[3]["result"]["seed"].clone();
    let job = server.job(&meshes[3], alone).await;
    let view = server.wait_for(&job, &["succeeded"]).await;
    assert_eq!(view["result"]["quality"], lines[3]["result"]["quality"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn requests_of_their_own_are_told_in_their_order() {
    let (server, mesh) = server(&["--workers", "2"]).await;
    let labels = ["paced", "a", "panic", "b", "endless", "c"];
    let requests =
        labels.map(|label| json!({"mesh_id": mesh, "label": label, "priority": "interactive"}));
    let id = submitted(&server, json!({"requests": requests})).await;
    let list = jobs(&server, &format!("&batch_id={id}")).await;
    assert_eq!(list.len(), 6);
    let endless = list.iter().find(|job| job["label"] == "endless").unwrap();
    let endless = endless["id"].as_str().unwrap();
    for job in &list {
        if job["label"] != "endless" {
            server
                .wait_for(job["id"].as_str().unwrap(), &["succeeded", "failed"])
                .await;
        }
    }
    server.wait_for(endless, &["running"]).await;
    let batch = server.json(&format!("/batches/{id}")).await;
    assert_eq!(batch["state"], "running");
    assert!(
        batch.get("finished_at").is_none() && batch["started_at"].is_string(),
        "{batch}"
    );
    let counts = json!({
        "total": 6, "queued": 0, "running": 1, "succeeded": 4, "failed": 1, "cancelled": 0, "forgotten": 0,
    });
    assert_eq!(batch["jobs"], counts);
    let lines = results(&server, &id, "").await;
    let told: Vec<&Value> = lines.iter().map(|line| &line["label"]).collect();
    assert_eq!(told, labels);
    assert_eq!(lines[2]["problem"]["type"], "/problems/internal-error");
    assert!(lines[4].get("result").is_none() && lines[4]["state"] == "running");
    assert_eq!(
        places(&results(&server, &id, "?state=succeeded").await),
        [0, 1, 3, 5]
    );
    assert_eq!(places(&results(&server, &id, "?after=2").await), [3, 4, 5]);
    assert_eq!(
        places(&results(&server, &id, "?after=1&state=succeeded").await),
        [3, 5]
    );
    assert!(results(&server, &id, "?after=9999").await.is_empty());

    // The wait ends with the last of them, and what is stopped keeps what it has found.
    let waiting = tokio::spawn(server.get(&format!("/batches/{id}?wait=60")).send());
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert!(!waiting.is_finished());
    let cancel = || server.post(&format!("/batches/{id}/cancel")).send();
    assert_eq!(cancel().await.unwrap().status(), StatusCode::ACCEPTED);
    let answer = waiting.await.unwrap().unwrap();
    assert!(!answer.headers().contains_key("retry-after"));
    let batch: Value = answer.json().await.unwrap();
    assert_eq!(
        (&batch["state"], &batch["jobs"]["cancelled"]),
        (&json!("ended"), &json!(1))
    );
    assert_eq!(cancel().await.unwrap().status(), StatusCode::OK);
    let lines = results(&server, &id, "?state=cancelled").await;
    assert!(
        lines[0]["result"]["generation"].as_u64().unwrap() > 0,
        "{lines:?}"
    );

    let path = format!("/batches/{id}");
    let tag = server.get(&path).send().await.unwrap().headers()["etag"].clone();
    let same = server.get(&path).header("if-none-match", tag).send().await;
    assert_eq!(same.unwrap().status(), StatusCode::NOT_MODIFIED);
    assert_eq!(server.delete(&path).send().await.unwrap().status(), 204);
    for resource in ["", "/results"] {
        let gone = server
            .get(&format!("{path}{resource}"))
            .send()
            .await
            .unwrap();
        problem(gone, 404).await;
    }
    problem(server.delete(&path).send().await.unwrap(), 404).await;
    assert!(jobs(&server, "").await.is_empty());
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_wrong_is_named_with_its_place_and_leaves_nothing() {
    let (server, mesh) = server(&[]).await;
    let tiny = server.mesh(cuboid([1.0; 3], 1)).await;
    let unknown = "0".repeat(64);
    for (body, expected) in [
        (json!([]), vec![""]),
        (json!({}), vec![""]),
        (json!({"meshes": []}), vec!["/meshes"]),
        (json!({"meshes": vec![&mesh; 10_001]}), vec!["/meshes"]),
        (json!({"meshes": [mesh, 7, unknown]}), vec!["/meshes/1"]),
        (
            json!({"meshes": [mesh, unknown, "x"]}),
            vec!["/meshes/1", "/meshes/2"],
        ),
        (
            json!({"meshes": [mesh], "request": {"contacts": 65}}),
            vec!["/request/contacts"],
        ),
        (
            json!({"meshes": [mesh], "requests": [{"mesh_id": mesh}]}),
            vec![""],
        ),
        (
            json!({"requests": [{"mesh_id": mesh}, {"mesh_id": unknown}, {"mesh_id": mesh}]}),
            vec!["/requests/1/mesh_id"],
        ),
        (
            json!({"requests": [{"mesh_id": mesh}, {"friction": -1}, 5], "labels": 1}),
            vec![
                "/labels",
                "/requests/1/friction",
                "/requests/1/mesh_id",
                "/requests/2",
            ],
        ),
        (
            json!({"meshes": [mesh, tiny, tiny], "request": {"contacts": 20, "candidates": "triangles"}}),
            vec!["/request/contacts"],
        ),
        (
            json!({"requests": [
                {"mesh_id": mesh},
                {"mesh_id": tiny, "contacts": 20, "method": "local"},
                {"mesh_id": mesh, "callback_url": "https://example.com/"},
            ]}),
            vec!["/requests/1/contacts", "/requests/2/callback_url"],
        ),
    ] {
        let told = problem(submit(&server, &body).await, 422).await;
        assert_eq!(pointers(&told), expected, "{told}");
    }
    for (kind, body, status) in [
        ("application/json", "{\"meshes\":", 400),
        ("application/json", "{\"meshes\":[],\"meshes\":[]}", 400),
        ("text/plain", "{}", 415),
    ] {
        let request = server.post("/batches").header("content-type", kind);
        problem(request.body(body).send().await.unwrap(), status).await;
    }
    let long = vec![b' '; 8 * 1024 * 1024 + 1];
    let request = server
        .post("/batches")
        .header("content-type", "application/json");
    problem(request.body(long).send().await.unwrap(), 413).await;
    let id = submitted(&server, json!({"meshes": [mesh]})).await;
    for query in [
        "?state=done",
        "?after=-1",
        "?after=10000",
        "?after=x",
        "?wait=1",
        "?after=1&after=2",
    ] {
        let refused = server.get(&format!("/batches/{id}/results{query}"));
        problem(refused.send().await.unwrap(), 400).await;
    }
    for path in [
        "/batches?limit=0",
        "/batches?cursor=x",
        "/batches?state=ended",
    ] {
        problem(server.get(path).send().await.unwrap(), 400).await;
    }
    let refused = server.get(&format!("/batches/{id}/results"));
    let refused = refused.header("accept", "application/json").send();
    problem(refused.await.unwrap(), 406).await;
    for unknown in ["x", "01a20203-4fd6-77c7-b546-6eed63910d31"] {
        for resource in ["", "/results"] {
            let absent = server.get(&format!("/batches/{unknown}{resource}?"));
            problem(absent.send().await.unwrap(), 404).await;
        }
        let absent = server.post(&format!("/batches/{unknown}/cancel"));
        problem(absent.send().await.unwrap(), 404).await;
    }
    ended(&server, &id).await;
    assert_eq!(
        jobs(&server, "").await.len(),
        1,
        "nothing of what was refused"
    );
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_waits_for_room_or_is_told_that_there_never_is_enough() {
    let (server, mesh) = server(&["--queue-capacity", "5"]).await;
    let blocker = server.job(&mesh, json!({"label": "endless"})).await;
    server.wait_for(&blocker, &["running"]).await;
    let of = |jobs: usize| json!({"meshes": vec![&mesh; jobs]});
    let never = problem(submit(&server, &of(6)).await, 422).await;
    assert_eq!(pointers(&never), ["/meshes"]);
    assert!(
        never["errors"][0]["detail"]
            .as_str()
            .unwrap()
            .contains("at most 5"),
        "{never}"
    );
    submitted(&server, of(3)).await;
    let full = submit(&server, &of(3)).await;
    assert!(full.headers().contains_key("retry-after"));
    assert_eq!(problem(full, 503).await["type"], "/problems/queue-full");
    let fits = submitted(&server, of(2)).await;
    assert_eq!(jobs(&server, "&state=queued").await.len(), 5);
    server
        .post(&format!("/jobs/{blocker}/cancel"))
        .send()
        .await
        .unwrap();
    ended(&server, &fits).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_submission_makes_one_batch() {
    let (server, mesh) = server(&[]).await;
    let send = async |key: &str, body: &Value| {
        let request = server.post("/batches").header("idempotency-key", key);
        request.json(body).send().await.unwrap()
    };
    let body = json!({"meshes": [mesh, mesh], "request": {"contacts": 5}, "label": "x"});
    let first = send("k", &body).await;
    assert_eq!(first.status(), StatusCode::ACCEPTED);
    let first = first.headers()["location"].clone();
    // Written otherwise, the same.
    let again = server
        .post("/batches")
        .header("idempotency-key", "k")
        .header("content-type", "application/json")
        .body(format!("{{\"label\":\"x\",\"request\":{{\"contacts\":5.0}},\n\"meshes\":[\"{mesh}\",\"{mesh}\"]}}"));
    let again = again.send().await.unwrap();
    assert_eq!(
        (again.status(), &again.headers()["location"]),
        (StatusCode::ACCEPTED, &first)
    );
    let list = jobs(&server, "").await;
    assert_eq!(list.len(), 2);
    let seeds: HashSet<u64> = list
        .iter()
        .map(|job| job["request"]["seed"].as_u64().unwrap())
        .collect();
    assert_eq!(seeds.len(), 2);
    for other in [
        json!({"meshes": [mesh, mesh], "request": {"contacts": 5}}),
        json!({"meshes": [mesh], "request": {"contacts": 5}, "label": "x"}),
        json!({"meshes": [mesh, mesh], "request": {"contacts": 6}, "label": "x"}),
    ] {
        let told = problem(send("k", &other).await, 422).await;
        assert_eq!(told["type"], "/problems/idempotency-key-reused");
    }
    // Nor does a key serve a job and a batch.
    let job = server.post("/jobs").header("idempotency-key", "k");
    let job = job.json(&json!({"mesh_id": mesh, "contacts": 5})).send();
    problem(job.await.unwrap(), 422).await;
    // What was refused has not used its key up.
    problem(send("l", &json!({"meshes": ["x"]})).await, 422).await;
    assert_eq!(send("l", &body).await.status(), StatusCode::ACCEPTED);
    let gone = server.delete(first.to_str().unwrap()).send().await;
    assert_eq!(gone.unwrap().status(), 204);
    problem(send("k", &body).await, 410).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn each_key_has_its_own_batches_and_its_share_of_the_queue() {
    let flags = ["--auth", "keys", "--max-queued-per-key", "3"];
    let server = server_with(&flags).await;
    let keys = SqliteKeys::open(&server.folder.path().join("data"))
        .await
        .unwrap();
    let make = async |name| keys.create(name, None).await.unwrap().text;
    let (a, b) = (make("a").await, make("b").await);
    let upload = server.post("/meshes").bearer_auth(&a);
    let mesh: Value = upload
        .multipart(crate::common::file(small_box()))
        .send()
        .await
        .unwrap()
        .json()
        .await
        .unwrap();
    let mesh = mesh["id"].as_str().unwrap();
    let long = json!({"population": 10_000, "generations": 90_000});
    let send = async |key: &str, jobs: usize| {
        let body = json!({"meshes": vec![mesh; jobs], "request": long});
        let request = server.post("/batches").bearer_auth(key).json(&body);
        request.send().await.unwrap()
    };
    let never = problem(send(&a, 4).await, 422).await;
    assert!(
        never["errors"][0]["detail"]
            .as_str()
            .unwrap()
            .contains("at most 3"),
        "{never}"
    );
    let taken = send(&a, 3).await;
    assert_eq!(taken.status(), StatusCode::ACCEPTED);
    let path = taken.headers()["location"].to_str().unwrap().to_owned();
    let used = send(&a, 3).await;
    assert!(used.headers().contains_key("retry-after"));
    problem(used, 429).await;
    assert_eq!(
        pointers(&problem(send(&b, 1).await, 422).await),
        ["/meshes/0"]
    );
    for resource in ["", "/results"] {
        let other = server.get(&format!("{path}{resource}")).bearer_auth(&b);
        problem(other.send().await.unwrap(), 404).await;
    }
    let cancel = server.post(&format!("{path}/cancel")).bearer_auth(&b);
    problem(cancel.send().await.unwrap(), 404).await;
    problem(
        server.delete(&path).bearer_auth(&b).send().await.unwrap(),
        404,
    )
    .await;
    let list = server.get("/batches").bearer_auth(&b).send().await.unwrap();
    let list: Value = list.json().await.unwrap();
    assert_eq!(list, json!({"batches": []}));
    problem(server.get(&path).send().await.unwrap(), 401).await;
    let mine = server.delete(&path).bearer_auth(&a).send().await.unwrap();
    assert_eq!(mine.status(), 204);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wait_ends_with_its_time_the_batch_or_the_server() {
    let (mut server, mesh) = server(&["--workers", "2"]).await;
    let endless = json!({"meshes": [mesh, mesh], "request": {"label": "endless"}});
    let stays = submitted(&server, endless.clone()).await;
    let clock = Instant::now();
    let answer = server
        .get(&format!("/batches/{stays}?wait=0.5"))
        .send()
        .await
        .unwrap();
    assert!(clock.elapsed() >= Duration::from_millis(500));
    assert!(answer.headers().contains_key("retry-after"));
    assert_eq!(answer.json::<Value>().await.unwrap()["state"], "running");
    let goes = submitted(&server, endless).await;
    let wait = |id: &str| tokio::spawn(server.get(&format!("/batches/{id}?wait=60")).send());
    let (on_stays, on_goes) = (wait(&stays), wait(&goes));
    tokio::time::sleep(Duration::from_millis(200)).await;
    let gone = server.delete(&format!("/batches/{goes}")).send().await;
    assert_eq!(gone.unwrap().status(), 204);
    problem(on_goes.await.unwrap().unwrap(), 404).await;
    assert!(!on_stays.is_finished());
    server.begin_stop();
    let view: Value = on_stays.await.unwrap().unwrap().json().await.unwrap();
    assert_eq!(view["state"], "running");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn thousands_of_jobs_are_taken_listed_and_read_in_pieces() {
    let (server, mesh) = server(&["--queue-capacity", "10000"]).await;
    let blocker = server.job(&mesh, json!({"label": "endless"})).await;
    server.wait_for(&blocker, &["running"]).await;
    let id = submitted(&server, json!({"meshes": vec![&mesh; 10_000]})).await;
    let view = server.json(&format!("/batches/{id}")).await;
    assert_eq!(view["jobs"]["queued"], 10_000);
    let lines = results(&server, &id, "").await;
    assert_eq!(places(&lines), (0..10_000).collect::<Vec<u64>>());
    let ids: HashSet<&str> = lines
        .iter()
        .map(|line| line["job_id"].as_str().unwrap())
        .collect();
    assert_eq!(ids.len(), 10_000);
    let cancelled = server.post(&format!("/batches/{id}/cancel")).send().await;
    assert_eq!(
        cancelled.unwrap().json::<Value>().await.unwrap()["jobs"]["cancelled"],
        10_000
    );
    let mut batches = vec![id];
    for jobs in 1..5 {
        batches.push(submitted(&server, json!({"meshes": vec![&mesh; jobs]})).await);
    }
    batches.reverse();
    let (mut listed, mut cursor) = (Vec::new(), String::new());
    loop {
        let page = server.json(&format!("/batches?limit=2{cursor}")).await;
        let page_of = page["batches"].as_array().unwrap();
        listed.extend(
            page_of
                .iter()
                .map(|batch| batch["id"].as_str().unwrap().to_owned()),
        );
        match page["next_cursor"].as_str() {
            Some(next) => cursor = format!("&cursor={next}"),
            None => break,
        }
    }
    assert_eq!(listed, batches);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_expires_with_its_jobs_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let flags = ["--retention", "2s"];
    let server = crate::common::start(folder, &flags, |_| {}, Some(scripted::runner())).await;
    let mesh = server.mesh(small_box()).await;
    let id = submitted(&server, json!({"meshes": [mesh, mesh]})).await;
    ended(&server, &id).await;
    let path = format!("/batches/{id}");
    let end = Instant::now() + Duration::from_secs(60);
    while server.get(&path).send().await.unwrap().status() == 200 {
        assert!(Instant::now() < end);
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    for resource in ["", "/results"] {
        let gone = server
            .get(&format!("{path}{resource}"))
            .send()
            .await
            .unwrap();
        problem(gone, 410).await;
    }
    let gone = server.post(&format!("{path}/cancel")).send().await.unwrap();
    problem(gone, 410).await;
    server.stop().await;
}
