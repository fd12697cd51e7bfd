//! Requests that cannot be used.

use super::*;

#[tokio::test(flavor = "multi_thread")]
async fn unusable_members_are_named() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let contact = |contact: Value| json!({"grasps": [[{"triangle": 1}], [contact]]});
    let with = |name: &str, value: Value| json!({"grasps": [[{"triangle": 1}]], name: value});
    for (mut body, pointer) in [
        (json!({}), "/grasps"),
        (json!({"grasps": []}), "/grasps"),
        (json!({"grasps": {"0": []}}), "/grasps"),
        (
            json!({"grasps": vec![[json!({"triangle": 1})]; 10_001]}),
            "/grasps",
        ),
        (json!({"grasps": [[{"triangle": 1}], []]}), "/grasps/1"),
        (
            json!({"grasps": [vec![json!({"triangle": 1}); 65]]}),
            "/grasps/0",
        ),
        (contact(json!(17)), "/grasps/1/0"),
        (contact(json!({})), "/grasps/1/0"),
        (
            contact(json!({"triangle": TRIANGLES})),
            "/grasps/1/0/triangle",
        ),
        (contact(json!({"triangle": -1})), "/grasps/1/0/triangle"),
        (contact(json!({"triangle": "1"})), "/grasps/1/0/triangle"),
        (
            contact(json!({"triangle": 1, "point": [0, 0, 0]})),
            "/grasps/1/0/triangle",
        ),
        (contact(json!({"point": [0, 0]})), "/grasps/1/0/point"),
        (contact(json!({"point": [0, 0, null]})), "/grasps/1/0/point"),
        (contact(json!({"point": [0, 0, 1e13]})), "/grasps/1/0/point"),
        (
            contact(json!({"point": [0, 0, 1], "normal": [0, 0, 0]})),
            "/grasps/1/0/normal",
        ),
        (
            contact(json!({"point": [0, 0, 1e6], "normal": [0, 0, 1]})),
            "/grasps/1/0/point",
        ),
        (contact(json!({"normal": [0, 0, 1]})), "/grasps/1/0"),
        (
            contact(json!({"triangle": 1, "finger": "thumb"})),
            "/grasps/1/0/finger",
        ),
        (
            with("external_wrench", json!([1, 2, 3])),
            "/external_wrench",
        ),
        (
            with("external_wrench", json!({"force": [1, 2]})),
            "/external_wrench/force",
        ),
        (with("external_wrenches", json!({})), "/external_wrenches"),
        (
            with("external_wrenches", json!([{}])),
            "/external_wrenches/0",
        ),
        (with("contacts", json!(4)), "/contacts"),
        (with("seed", json!(4)), "/seed"),
        (with("friction", json!(-1)), "/friction"),
        (with("cone_edges", json!(2)), "/cone_edges"),
        (with("wrench_space", json!("l2")), "/wrench_space"),
        (with("torsional_friction", json!(1)), "/torsional_friction"),
        (with("torque_scale", json!(1e9)), "/torque_scale"),
        (
            with("center_of_mass", json!([0, 0, 1e9])),
            "/center_of_mass",
        ),
    ] {
        let text = body.to_string();
        body["mesh_id"] = mesh.as_str().into();
        let found = refused(&server, &body, 422).await;
        let shown = &text[..text.len().min(200)];
        assert_eq!(pointers(&found), [pointer], "{shown}");
        let form = file(small_box()).part("request", Part::text(text.clone()));
        let answer = server.post("/evaluations").multipart(form).send().await;
        assert_eq!(problem(answer.unwrap(), 422).await, found, "{shown}");
    }
    for mesh_id in [Value::Null, json!(7), json!("nope"), json!("0".repeat(64))] {
        let body = json!({"mesh_id": mesh_id, "grasps": [[{"triangle": 1}]]});
        assert_eq!(pointers(&refused(&server, &body, 422).await), ["/mesh_id"]);
    }
    let many = json!({"mesh_id": mesh, "grasps": vec![[json!({"triangle": 99_999})]; 50]});
    assert_eq!(pointers(&refused(&server, &many, 422).await).len(), 20);
}

#[tokio::test(flavor = "multi_thread")]
async fn triangles_without_a_normal_are_refused() {
    let server = server().await;
    let mut bytes = small_box();
    let sliver = stl(&[[[0.0, 0.0, 1.5], [0.25, 0.0, 1.5], [0.125, 0.0, 1.5]]]);
    bytes.extend(&sliver[84..]);
    bytes[80..84].copy_from_slice(&(TRIANGLES as u32 + 1).to_le_bytes());
    let mesh = server.mesh(bytes).await;
    let body = json!({"mesh_id": mesh, "grasps": [[{"triangle": TRIANGLES}]]});
    let found = refused(&server, &body, 422).await;
    assert_eq!(pointers(&found), ["/grasps/0/0/triangle"]);
    assert!(
        found["errors"][0]["detail"]
            .as_str()
            .unwrap()
            .contains("degenerate")
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn malformed_requests_are_refused_before_they_are_read() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let send = async |kind: &str, body: Vec<u8>| {
        let request = server.post("/evaluations").header("content-type", kind);
        request.body(body).send().await.unwrap()
    };
    let deep = format!("{{\"grasps\":{}{}}}", "[".repeat(200), "]".repeat(200));
    for body in [
        "",
        "{",
        "{} {}",
        "{\"friction\":1,\"friction\":1}",
        "{\"grasps\":[[{\"triangle\":1,\"triangle\":1}]]}",
        &deep,
    ] {
        problem(send("application/json", body.into()).await, 400).await;
    }
    problem(send("text/plain", b"{}".to_vec()).await, 415).await;
    problem(
        send("application/json; charset=utf-16", b"{}".to_vec()).await,
        415,
    )
    .await;
    let long = vec![b' '; (8 << 20) + 1];
    problem(send("application/json", long.clone()).await, 413).await;
    let form = file(small_box()).text("grasps", String::from_utf8(long).unwrap());
    let answer = server.post("/evaluations").multipart(form).send().await;
    problem(answer.unwrap(), 413).await;
    let no_mesh = Part::bytes(b"%PDF-1.7, and no mesh".to_vec()).file_name("box.stl");
    for (form, status) in [
        (Form::new().text("grasps", "[[{\"triangle\":1}]]"), 400),
        (
            file(small_box()).part("mesh", Part::bytes(small_box()).file_name("b.stl")),
            400,
        ),
        (
            file(small_box())
                .text("friction", "1")
                .text("request", "{}"),
            400,
        ),
        (
            Form::new()
                .part("mesh", no_mesh)
                .text("grasps", "[[{\"triangle\":1}]]"),
            415,
        ),
        (file(small_box()).text("grasps", "[[{"), 422),
    ] {
        let answer = server.post("/evaluations").multipart(form).send().await;
        problem(answer.unwrap(), status).await;
    }

    let body = json!({"mesh_id": mesh, "grasps": [[{"triangle": 1}]]});
    let html = server
        .post("/evaluations")
        .header("accept", "text/html")
        .json(&body);
    problem(html.send().await.unwrap(), 406).await;
    let query = server.post("/evaluations?format=stl").json(&body);
    problem(query.send().await.unwrap(), 400).await;
    let answer = server.get("/evaluations").send().await.unwrap();
    assert_eq!(answer.headers()["allow"], "POST");
    problem(answer, 405).await;

    // Much more than a planning request may have.
    let mut padded = body.to_string().into_bytes();
    padded.resize(1 << 20, b' ');
    assert_eq!(
        send("application/json", padded).await.status(),
        StatusCode::OK
    );
    server.service.begin_drain();
    refused(&server, &body, 503).await;
    let form = file(small_box()).text("grasps", "[[{\"triangle\":1}]]");
    let answer = server.post("/evaluations").multipart(form).send().await;
    problem(answer.unwrap(), 503).await;
}
