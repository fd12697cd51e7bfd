//! The service itself: landing page, health, description, headers of every answer.

use reqwest::{Response, StatusCode};
use serde_json::{Value, json};

use crate::common::{file, problem, server, small_box};

#[tokio::test(flavor = "multi_thread")]
async fn it_lives_and_is_ready() {
    let server = server().await;
    for path in ["/healthz", "/readyz"] {
        assert_eq!(server.json(path).await["status"], "ok");
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_that_drains_takes_no_work_but_still_answers() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    server.service.begin_drain();
    let job = json!({"mesh_id": mesh});
    let grasps = json!({"mesh_id": mesh, "grasps": [[{"triangle": 1}]]});
    for request in [
        server.get("/readyz"),
        server.post("/jobs").json(&job),
        server.post("/jobs").multipart(file(small_box())),
        server.post("/meshes").multipart(file(small_box())),
        server.post("/evaluations").json(&grasps),
    ] {
        let answer = request.send().await.unwrap();
        assert!(answer.headers().contains_key("retry-after"));
        problem(answer, 503).await;
    }
    for path in ["/healthz", "/meshes", "/jobs"] {
        server.json(path).await;
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_landing_page_is_html_or_json_by_accept() {
    let server = server().await;
    assert_eq!(server.json("/").await["name"], "graspd");
    let depends = |answer: &Response| {
        let vary = answer.headers().get_all("vary").iter();
        vary.flat_map(|value| value.to_str().unwrap().split(','))
            .any(|name| name.trim() == "accept")
    };
    assert!(depends(&server.get("/").send().await.unwrap()));
    let page = server
        .get("/")
        .header("accept", "text/html,*/*;q=0.8")
        .send()
        .await
        .unwrap();
    assert!(depends(&page));
    let policy = page.headers()["content-security-policy"].to_str().unwrap();
    assert!(
        policy.starts_with("default-src 'none'") && !policy.contains("unsafe"),
        "{policy}"
    );
    assert!(page.text().await.unwrap().contains("<title>graspd"));
    let neither = server
        .get("/")
        .header("accept", "image/png")
        .send()
        .await
        .unwrap();
    problem(neither, 406).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_description_is_served_and_its_page_needs_no_other_host() {
    let server = server().await;
    let served = server.json("/openapi.json").await;
    let kept: Value = serde_json::from_str(&graspd::http::openapi_json().unwrap()).unwrap();
    assert_eq!(served, kept);
    let page = server.get("/docs/").send().await.unwrap();
    assert_eq!(page.status(), StatusCode::OK);
    let html = page.text().await.unwrap();
    assert!(
        !html.contains("http://") && !html.contains("https://"),
        "{html}"
    );
}

#[test]
fn the_description_in_the_repository_is_up_to_date() {
    let command = "cargo run -- openapi --output openapi/openapi.json";
    let kept = std::fs::read_to_string("openapi/openapi.json").unwrap_or_default();
    let fresh = graspd::http::openapi_json().unwrap();
    assert!(
        kept == fresh,
        "openapi/openapi.json is stale; run: {command}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn every_operation_has_its_own_id_and_describes_its_errors() {
    let text = graspd::http::openapi_json().unwrap();
    let api: Value = serde_json::from_str(&text).unwrap();
    let mut ids = Vec::new();
    for path in api["paths"].as_object().unwrap().values() {
        for operation in path.as_object().unwrap().values() {
            ids.push(operation["operationId"].as_str().unwrap().to_owned());
            for (status, response) in operation["responses"].as_object().unwrap() {
                if status.starts_with(['4', '5']) {
                    assert!(response["content"]["application/problem+json"].is_object());
                }
            }
        }
    }
    let count = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), count);
    for reference in text.split("\"$ref\": \"#").skip(1) {
        let pointer = reference.split('"').next().unwrap();
        assert!(api.pointer(pointer).is_some(), "{pointer} leads nowhere");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn answers_carry_an_id_and_say_what_browsers_may_not_do() {
    let server = server().await;
    let kept = server
        .get("/healthz")
        .header("x-request-id", "abc-1.2")
        .send()
        .await
        .unwrap();
    assert_eq!(kept.headers()["x-request-id"], "abc-1.2");
    assert_eq!(kept.headers()["x-content-type-options"], "nosniff");
    assert_eq!(kept.headers()["x-frame-options"], "DENY");
    assert!(kept.headers().contains_key("content-security-policy"));
    let long = "a".repeat(129);
    for unfit in ["a b", "<script>", long.as_str()] {
        let answer = server
            .get("/nowhere")
            .header("x-request-id", unfit)
            .send()
            .await
            .unwrap();
        let id = answer.headers()["x-request-id"]
            .to_str()
            .unwrap()
            .to_owned();
        assert!(id != unfit && id.len() == 36, "{id}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn head_works_where_get_does() {
    let server = server().await;
    for path in [
        "/",
        "/healthz",
        "/readyz",
        "/jobs",
        "/meshes",
        "/openapi.json",
        "/docs/",
    ] {
        let answer = server.client.head(server.url(path)).send().await.unwrap();
        assert_eq!(answer.status(), StatusCode::OK, "{path}");
        assert!(answer.bytes().await.unwrap().is_empty());
    }
}

/// The members of an object and of the objects in it, the first of each list standing for all.
fn shape(value: &Value, place: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(object) => {
            for (name, value) in object {
                let place = format!("{place}/{name}");
                shape(value, &place, found);
                found.push(place);
            }
        }
        Value::Array(items) => {
            for item in items.iter().take(1) {
                shape(item, &format!("{place}/-"), found);
            }
        }
        _ => {}
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_examples_of_the_description_look_like_real_answers() {
    let text = graspd::http::openapi_json().unwrap();
    let api: Value = serde_json::from_str(&text).unwrap();
    let shown = |path: &str, method: &str, status: &str| {
        let operation = &api["paths"][path][method];
        operation["responses"][status]["content"]["application/json"]["example"].clone()
    };
    let server = server().await;
    let form = file(small_box())
        .text("population", "2")
        .text("generations", "2")
        .text("friction", "0.5")
        .text("seed", "1")
        .text("label", "a box");
    let answer = server.post("/jobs").multipart(form).send().await.unwrap();
    let queued: Value = answer.json().await.unwrap();
    let (id, mesh) = (queued["id"].as_str().unwrap(), &queued["mesh_id"]);
    let job = server.wait_for(id, &["succeeded"]).await;
    let result = server.json(&format!("/jobs/{id}/result")).await;
    let list = server.json("/meshes").await;
    let contacts = result["contacts"].as_array().unwrap().iter();
    let grasp: Vec<Value> = contacts
        .map(|contact| json!({"point": contact["position"]}))
        .collect();
    let request = json!({"mesh_id": mesh, "grasps": [grasp]});
    let answer = server
        .post("/evaluations")
        .json(&request)
        .send()
        .await
        .unwrap();
    let evaluations: Value = answer.json().await.unwrap();
    for (example, real, but) in [
        (shown("/jobs", "post", "202"), queued.clone(), &[][..]),
        (
            shown("/jobs/{id}", "get", "200"),
            job,
            &["/mesh_report/warnings/-"],
        ),
        (shown("/jobs/{id}/result", "get", "200"), result, &[]),
        (
            shown("/meshes", "get", "200"),
            list,
            &["/meshes/-/report/warnings/-", "/meshes/-/file_name"],
        ),
        (
            shown("/evaluations", "post", "200"),
            evaluations,
            &["/evaluations/-/contacts/-/distance"],
        ),
    ] {
        let shape = |value: &Value| {
            let mut found = Vec::new();
            shape(value, "", &mut found);
            found.retain(|place| !but.iter().any(|but| place.starts_with(but)));
            found.sort();
            found
        };
        assert_eq!(shape(&example), shape(&real));
    }
    let problem =
        &api["paths"]["/jobs"]["post"]["responses"]["422"]["content"]["application/problem+json"];
    assert_eq!(problem["example"]["errors"][0]["pointer"], "/contacts");
}
