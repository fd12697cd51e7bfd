//! Who may come in, what each sees, and how often.

use std::process::Command;

use graspd::store::Keys as _;
use graspd::store::sqlite::SqliteKeys;
use reqwest::{Method, StatusCode};
use serde_json::{Value, json};

use crate::common::{Server, file, problem, server, server_with, small_box};

/// A server that wants keys, and two of them.
async fn guarded(flags: &[&str]) -> (Server, [String; 2]) {
    let flags = [&["--auth", "keys"], flags].concat();
    let server = server_with(&flags).await;
    let keys = keys(&server).await;
    let make = async |name| keys.create(name, None).await.unwrap().text;
    let made = [make("a").await, make("b").await];
    (server, made)
}

async fn keys(server: &Server) -> SqliteKeys {
    SqliteKeys::open(&server.folder.path().join("data"))
        .await
        .unwrap()
}

/// Uploads the box and submits a job on it; ids of mesh and job.
async fn send(server: &Server, key: &str, request: Value) -> (String, String) {
    let answer = server
        .post("/jobs")
        .bearer_auth(key)
        .multipart(file(small_box()).text("request", request.to_string()))
        .send()
        .await
        .unwrap();
    assert_eq!(answer.status(), StatusCode::ACCEPTED);
    let job: Value = answer.json().await.unwrap();
    let text = |name: &str| job[name].as_str().unwrap().to_owned();
    (text("mesh_id"), text("id"))
}

fn quick() -> Value {
    json!({"population": 20, "generations": 2, "seed": 7, "candidates": "triangles"})
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_can_be_read_without_a_valid_key() {
    let (server, [key, _]) = guarded(&[]).await;
    let open = ["/", "/docs/", "/openapi.json", "/healthz", "/readyz"];
    for path in open {
        assert_eq!(
            server.get(path).send().await.unwrap().status(),
            200,
            "{path}"
        );
    }
    let id = "a".repeat(64);
    let guarded = [
        (Method::GET, "/jobs".to_owned()),
        (Method::POST, "/jobs".to_owned()),
        (Method::GET, format!("/jobs/{id}")),
        (Method::GET, format!("/jobs/{id}/result")),
        (Method::POST, format!("/jobs/{id}/cancel")),
        (Method::DELETE, format!("/jobs/{id}")),
        (Method::GET, "/meshes".to_owned()),
        (Method::POST, "/meshes".to_owned()),
        (Method::GET, format!("/meshes/{id}/preview.png")),
        (Method::GET, format!("/meshes/{id}/file")),
        (Method::GET, format!("/jobs/{id}/grasp.glb")),
        (Method::POST, "/evaluations".to_owned()),
        (Method::GET, "/batches".to_owned()),
        (Method::POST, "/batches".to_owned()),
        (Method::GET, format!("/batches/{id}")),
        (Method::GET, format!("/batches/{id}/results")),
        (Method::POST, format!("/batches/{id}/cancel")),
        (Method::DELETE, format!("/batches/{id}")),
    ];
    for (method, path) in guarded {
        let answer = server.client.request(method, server.url(&path)).send();
        let answer = answer.await.unwrap();
        let challenge = answer.headers().get("www-authenticate").cloned();
        problem(answer, 401).await;
        assert!(
            challenge.unwrap().to_str().unwrap().starts_with("Bearer"),
            "{path}"
        );
    }
    for line in [
        format!("Bearer {key}x"),
        format!("Basic {key}"),
        key.clone(),
        "Bearer".to_owned(),
    ] {
        let answer = server.get("/jobs").header("authorization", line).send();
        problem(answer.await.unwrap(), 401).await;
    }
    let answer = server.get("/jobs").bearer_auth(&key).send().await.unwrap();
    assert_eq!(answer.status(), 200);
    let answer = server
        .get("/jobs")
        .header("authorization", format!("bearer {key}"));
    assert_eq!(answer.send().await.unwrap().status(), 200);
    let twice = server.get("/jobs").bearer_auth(&key).bearer_auth(&key);
    problem(twice.send().await.unwrap(), 401).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn another_s_things_look_like_nothing_at_all() {
    let (server, [a, b]) = guarded(&[]).await;
    let (mesh, job) = send(&server, &a, quick()).await;
    let nothing = [
        "f".repeat(64),
        "01a20203-4fd6-77c7-b546-6eed63910d31".to_owned(),
    ];
    for (method, path) in [
        (Method::GET, "/jobs/JOB"),
        (Method::GET, "/jobs/JOB/result"),
        (Method::POST, "/jobs/JOB/cancel"),
        (Method::DELETE, "/jobs/JOB"),
        (Method::GET, "/meshes/MESH"),
        (Method::GET, "/meshes/MESH/preview.png"),
        (Method::GET, "/meshes/MESH/preview.svg"),
        (Method::GET, "/meshes/MESH/file"),
        (Method::GET, "/jobs/JOB/grasp.glb"),
        (Method::GET, "/jobs/JOB/grasp.csv"),
        (Method::GET, "/jobs/JOB/convergence.csv"),
        (Method::GET, "/jobs/JOB/grasp.isaac.yaml"),
        (Method::GET, "/jobs/JOB/grasp.moveit.json"),
        (Method::DELETE, "/meshes/MESH"),
    ] {
        let ask = async |mesh: &str, job: &str| {
            let path = path.replace("MESH", mesh).replace("JOB", job);
            let answer = server.client.request(method.clone(), server.url(&path));
            let answer = answer.bearer_auth(&b).send().await.unwrap();
            let status = answer.status();
            (status, answer.bytes().await.unwrap())
        };
        let (status, there) = ask(&mesh, &job).await;
        assert_eq!(status, 404, "{path}");
        assert_eq!(
            (status, there),
            ask(&nothing[0], &nothing[1]).await,
            "{path}"
        );
    }
    for path in ["/jobs", "/meshes"] {
        let list: Value = server
            .get(path)
            .bearer_auth(&b)
            .send()
            .await
            .unwrap()
            .json()
            .await
            .unwrap();
        assert!(list[&path[1..]].as_array().unwrap().is_empty(), "{list}");
    }
    let body = json!({"mesh_id": mesh});
    let answer = server
        .post("/jobs")
        .bearer_auth(&b)
        .json(&body)
        .send()
        .await
        .unwrap();
    problem(answer, 422).await;
    let body = json!({"mesh_id": mesh, "grasps": [[{"triangle": 0}]]});
    let answer = server
        .post("/evaluations")
        .bearer_auth(&b)
        .json(&body)
        .send()
        .await
        .unwrap();
    problem(answer, 422).await;

    // The same bytes are b's own mesh, new to b, and the one of a outlives it.
    let upload = server
        .post("/meshes")
        .bearer_auth(&b)
        .multipart(file(small_box()));
    let answer = upload.send().await.unwrap();
    assert_eq!(answer.status(), StatusCode::CREATED);
    assert_eq!(answer.json::<Value>().await.unwrap()["id"], mesh.as_str());
    let path = format!("/meshes/{mesh}");
    let deleted = server.delete(&path).bearer_auth(&b).send().await.unwrap();
    assert_eq!(deleted.status(), StatusCode::NO_CONTENT);
    let kept = server.get(&path).bearer_auth(&a).send().await.unwrap();
    assert_eq!(kept.status(), 200);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_revoked_key_is_refused_at_once() {
    let (server, [a, b]) = guarded(&[]).await;
    send(&server, &a, quick()).await;
    let id = a.split('_').nth(1).unwrap();
    assert!(keys(&server).await.revoke(id).await.unwrap());
    problem(
        server.get("/jobs").bearer_auth(&a).send().await.unwrap(),
        401,
    )
    .await;
    assert_eq!(
        server
            .get("/jobs")
            .bearer_auth(&b)
            .send()
            .await
            .unwrap()
            .status(),
        200
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn twenty_bad_keys_are_enough() {
    let (server, [key, _]) = guarded(&[]).await;
    let mut refused = Vec::new();
    for attempt in 0..25 {
        let bad = format!("graspd_{attempt}_x");
        let answer = server.get("/jobs").bearer_auth(bad).send().await.unwrap();
        refused.push(answer.status().as_u16());
        if answer.status() == 429 {
            assert!(answer.headers().contains_key("retry-after"));
            problem(answer, 429).await;
        }
    }
    assert_eq!(refused[..20], [401; 20]);
    assert!(refused[20..].contains(&429), "{refused:?}");
    // Who has a good one is not made to pay for it.
    assert_eq!(
        server
            .get("/jobs")
            .bearer_auth(&key)
            .send()
            .await
            .unwrap()
            .status(),
        200
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn the_remaining_rate_is_reported_before_it_is_used_up() {
    let (server, [a, b]) = guarded(&["--rate-limit", "5"]).await;
    for left in (0..5).rev() {
        let answer = server.get("/jobs").bearer_auth(&a).send().await.unwrap();
        assert_eq!(answer.status(), 200);
        assert_eq!(
            answer.headers()["ratelimit-policy"],
            "\"requests\";q=5;w=60"
        );
        let standing = answer.headers()["ratelimit"].to_str().unwrap().to_owned();
        assert!(
            standing.starts_with(&format!("\"requests\";r={left};t=")),
            "{standing}"
        );
    }
    let answer = server.get("/jobs").bearer_auth(&a).send().await.unwrap();
    let wait: u64 = answer.headers()["retry-after"]
        .to_str()
        .unwrap()
        .parse()
        .unwrap();
    assert!((1..=12).contains(&wait), "{wait}");
    assert!(
        answer.headers()["ratelimit"]
            .to_str()
            .unwrap()
            .contains("r=0")
    );
    problem(answer, 429).await;
    assert_eq!(
        server
            .get("/jobs")
            .bearer_auth(&b)
            .send()
            .await
            .unwrap()
            .status(),
        200
    );
    assert_eq!(server.get("/healthz").send().await.unwrap().status(), 200);
}

#[tokio::test(flavor = "multi_thread")]
async fn quotas_are_refused_with_what_to_do() {
    let flags = [
        "--max-queued-per-key",
        "2",
        "--max-mesh-bytes-per-key",
        "12KiB",
    ];
    let (server, [a, b]) = guarded(&flags).await;
    let endless = json!({"population": 10_000, "generations": 90_000, "seed": 7});
    let (mesh, running) = send(&server, &a, endless.clone()).await;
    let running = format!("/jobs/{running}");
    loop {
        let job = server.get(&running).bearer_auth(&a).send().await.unwrap();
        if job.json::<Value>().await.unwrap()["state"] == "running" {
            break;
        }
        tokio::time::sleep(std::time::Duration::from_millis(10)).await;
    }
    let mut request = endless.clone();
    request["mesh_id"] = mesh.into();
    let submit = async || {
        server
            .post("/jobs")
            .bearer_auth(&a)
            .json(&request)
            .send()
            .await
            .unwrap()
    };
    assert_eq!(submit().await.status(), 202);
    assert_eq!(submit().await.status(), 202);
    let refused = submit().await;
    for header in ["retry-after", "ratelimit", "ratelimit-policy"] {
        assert!(refused.headers().contains_key(header), "{header}");
    }
    assert_eq!(problem(refused, 429).await["type"], "/problems/queued-jobs");
    send(&server, &b, endless).await;

    let other = crate::common::cuboid([1.0, 2.0, 4.0], 4);
    let upload = server
        .post("/meshes")
        .bearer_auth(&a)
        .multipart(file(other));
    let refused = upload.send().await.unwrap();
    assert_eq!(problem(refused, 429).await["type"], "/problems/mesh-bytes");
    assert_eq!(server.kept_files().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn pages_of_other_origins_come_in_only_where_allowed() {
    let origin = "https://app.example";
    let closed = server().await;
    let answer = closed
        .get("/jobs")
        .header("origin", origin)
        .send()
        .await
        .unwrap();
    assert!(!answer.headers().contains_key("access-control-allow-origin"));

    let (server, [key, _]) = guarded(&[
        "--cors-origins",
        "https://app.example,http://localhost:5173",
    ])
    .await;
    let preflight = |from: &'static str| {
        server
            .client
            .request(Method::OPTIONS, server.url("/jobs"))
            .header("origin", from)
            .header("access-control-request-method", "POST")
            .header(
                "access-control-request-headers",
                "authorization,idempotency-key",
            )
            .send()
    };
    let answer = preflight("https://app.example").await.unwrap();
    assert_eq!(answer.status(), 200);
    assert_eq!(answer.headers()["access-control-allow-origin"], origin);
    let allowed = answer.headers()["access-control-allow-headers"]
        .to_str()
        .unwrap();
    assert!(
        allowed.contains("authorization") && allowed.contains("idempotency-key"),
        "{allowed}"
    );
    let answer = preflight("https://evil.example").await.unwrap();
    assert!(!answer.headers().contains_key("access-control-allow-origin"));

    // What is refused can be read too.
    for key in [key.as_str(), "bad"] {
        let answer = server
            .get("/jobs")
            .bearer_auth(key)
            .header("origin", origin)
            .send()
            .await
            .unwrap();
        assert_eq!(answer.headers()["access-control-allow-origin"], origin);
    }
}

#[test]
fn a_public_address_without_keys_must_be_requested() {
    let folder = tempfile::tempdir().unwrap();
    let graspd = || {
        let mut command = Command::new(testkit::process::binary());
        command
            .args(["serve", "--listen", "0.0.0.0:0", "--data-dir"])
            .arg(folder.path());
        command
    };
    let output = graspd().output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("--auth keys") && said.contains("--auth off"),
        "{said}"
    );
    for auth in ["keys", "off"] {
        let mut child = graspd()
            .args(["--auth", auth])
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        let out = child.stdout.take().unwrap();
        std::io::BufRead::read_line(&mut std::io::BufReader::new(out), &mut line).unwrap();
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(
            line.starts_with("graspd listening on http://0.0.0.0:"),
            "{auth}: {line}"
        );
    }
}

#[test]
fn keys_are_made_listed_and_revoked_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let keys = |arguments: &[&str]| {
        let output = Command::new(testkit::process::binary())
            .arg("keys")
            .args(arguments)
            .arg("--data-dir")
            .arg(folder.path().join("new"))
            .output()
            .unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (
            output.status.code(),
            text(output.stdout),
            text(output.stderr),
        )
    };
    let (code, key, _) = keys(&["create", "robot arm", "--expires", "90d"]);
    assert_eq!(code, Some(0));
    assert!(
        key.starts_with("graspd_") && key.ends_with('\n') && key.lines().count() == 1,
        "{key}"
    );
    let id = key.split('_').nth(1).unwrap();
    let (_, listed, _) = keys(&["list", "--json"]);
    let listed: Value = serde_json::from_str(&listed).unwrap();
    assert_eq!(
        (&listed[0]["id"], &listed[0]["name"]),
        (&json!(id), &json!("robot arm"))
    );
    assert!(listed[0]["expires_at"].is_string() && listed[0].get("revoked_at").is_none());
    assert!(keys(&["list"]).1.contains("robot arm"));
    assert_eq!(keys(&["revoke", id]).0, Some(0));
    let (_, listed, _) = keys(&["list", "--json"]);
    assert!(serde_json::from_str::<Value>(&listed).unwrap()[0]["revoked_at"].is_string());
    let (code, _, said) = keys(&["revoke", "nobody"]);
    assert!(code == Some(1) && said.contains("nobody"), "{said}");
    assert_eq!(keys(&["create", "a\nb"]).0, Some(2));
    assert_eq!(keys(&["create", "--expires", "soon"]).0, Some(2));
}

#[tokio::test(flavor = "multi_thread")]
async fn waiting_clients_of_a_revoked_key_are_cut_off() {
    let (server, [a, _]) = guarded(&[]).await;
    let endless = json!({"population": 10_000, "generations": 90_000, "seed": 7});
    let (_, job) = send(&server, &a, endless).await;
    let events = server.get(&format!("/jobs/{job}/events")).bearer_auth(&a);
    let mut events = events.send().await.unwrap();
    assert_eq!(events.status(), 200);
    let waiting = server.get(&format!("/jobs/{job}?wait=30")).bearer_auth(&a);
    let waiting = tokio::spawn(waiting.send());
    events.chunk().await.unwrap().unwrap();

    let keys = keys(&server).await;
    let id = a.split('_').nth(1).unwrap();
    assert!(keys.revoke(id).await.unwrap());
    assert_eq!(keys.cancel_jobs(id).await.unwrap(), 1);
    while events.chunk().await.unwrap().is_some() {}
    problem(waiting.await.unwrap().unwrap(), 401).await;
}
