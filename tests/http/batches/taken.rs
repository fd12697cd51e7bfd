//! Batches that are accepted, planned and returned.

use super::*;

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
async fn results_of_separate_requests_keep_their_order() {
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
    let found: Vec<&Value> = lines.iter().map(|line| &line["label"]).collect();
    assert_eq!(found, labels);
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
    is_gone(&server, &path, 404).await;
    problem(server.delete(&path).send().await.unwrap(), 404).await;
    assert!(jobs(&server, "").await.is_empty());
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
        let refusal = problem(send("k", &other).await, 422).await;
        assert_eq!(refusal["type"], "/problems/idempotency-key-reused");
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
