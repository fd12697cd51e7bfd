//! Batches that are not taken, for what is wrong with them, for want of room or for whom they are not.

use super::*;

#[tokio::test(flavor = "multi_thread")]
async fn faults_are_located_and_nothing_is_stored() {
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
        let answer = problem(submit(&server, &body).await, 422).await;
        assert_eq!(pointers(&answer), expected, "{answer}");
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
async fn a_batch_that_can_never_fit_is_refused_otherwise_than_one_that_must_wait() {
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
