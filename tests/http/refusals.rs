//! What is refused, with which status, before any job or mesh is looked at.

use reqwest::multipart::{Form, Part};
use reqwest::{Body, Method, StatusCode};
use serde_json::json;

use crate::common::{file, pointers, problem, server, server_with, small_box};

#[tokio::test(flavor = "multi_thread")]
async fn unknown_paths_are_not_found() {
    let server = server().await;
    for path in [
        "/nowhere",
        "/jobs/",
        "/jobs/no-such-job",
        "/jobs/..%2f..%2fetc%2fpasswd",
        "/meshes/%2e%2e%2fx",
        "/meshes/%ff",
        "/jobs/x/result",
        "/jobs/0190163d-8694-739b-aea5-966c26f8ad90",
    ] {
        problem(server.get(path).send().await.unwrap(), 404).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn wrong_methods_are_answered_with_the_allowed_ones() {
    let server = server().await;
    for (method, path, allowed) in [
        (Method::PUT, "/jobs", "POST"),
        (Method::PATCH, "/jobs/x", "DELETE"),
        (Method::POST, "/jobs/x/result", "GET"),
        (Method::GET, "/jobs/x/cancel", "POST"),
        (Method::DELETE, "/meshes", "POST"),
        (Method::TRACE, "/meshes/x", "GET"),
        (Method::POST, "/healthz", "GET"),
        (Method::POST, "/readyz", "GET"),
        (Method::POST, "/", "GET"),
        (Method::DELETE, "/openapi.json", "GET"),
    ] {
        let request = server.client.request(method.clone(), server.url(path));
        let answer = request.send().await.unwrap();
        let allow = answer.headers().get("allow").cloned();
        problem(answer, 405).await;
        let allow = allow.unwrap_or_else(|| panic!("{method} {path} has no Allow"));
        assert!(
            allow.to_str().unwrap().contains(allowed),
            "{path}: {allow:?}"
        );
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_accept_that_json_does_not_meet_is_refused() {
    let server = server().await;
    for path in ["/jobs", "/meshes", "/jobs/x", "/openapi.json"] {
        let answer = server
            .get(path)
            .header("accept", "text/html")
            .send()
            .await
            .unwrap();
        problem(answer, 406).await;
    }
    // Nothing is to choose where a probe asks or an answer has no body.
    let mesh = server.mesh(small_box()).await;
    for (request, status) in [
        (server.get("/healthz"), 200),
        (server.get("/readyz"), 200),
        (server.delete(&format!("/meshes/{mesh}")), 204),
    ] {
        let answer = request.header("accept", "text/html").send().await.unwrap();
        assert_eq!(answer.status(), status);
    }
    let upload = server
        .post("/meshes")
        .header("accept", "image/png")
        .multipart(file(small_box()));
    problem(upload.send().await.unwrap(), 406).await;
    assert_eq!(server.json("/meshes").await["meshes"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn bodies_of_another_kind_are_refused() {
    let server = server().await;
    for kind in [
        "text/plain",
        "application/x-www-form-urlencoded",
        "application/json; charset=utf-16",
        "",
    ] {
        let request = server.post("/jobs").header("content-type", kind).body("{}");
        problem(request.send().await.unwrap(), 415).await;
    }
    problem(server.post("/jobs").body("{}").send().await.unwrap(), 415).await;
    problem(
        server.post("/meshes").body("solid").send().await.unwrap(),
        415,
    )
    .await;
    let utf16: Vec<u8> = "{}".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let request = server
        .post("/jobs")
        .header("content-type", "application/json")
        .body(utf16);
    problem(request.send().await.unwrap(), 415).await;
    for path in ["/jobs", "/meshes"] {
        let request = server
            .post(path)
            .header("content-encoding", "gzip")
            .multipart(file(small_box()));
        problem(request.send().await.unwrap(), 415).await;
        let request = server
            .post(path)
            .header("content-encoding", "Identity")
            .header("content-encoding", "gzip");
        problem(request.body("x").send().await.unwrap(), 415).await;
    }
    for kind in ["image/png", "application/json; charset=utf-16"] {
        let part = Part::text("{}").mime_str(kind).unwrap();
        let form = file(small_box()).part("request", part);
        let request = server.post("/jobs").multipart(form);
        problem(request.send().await.unwrap(), 415).await;
    }
    let plain = server
        .post("/meshes?format=stl")
        .header("content-encoding", "Identity")
        .body(small_box());
    assert_eq!(plain.send().await.unwrap().status(), StatusCode::CREATED);
}

#[tokio::test(flavor = "multi_thread")]
async fn files_of_other_kinds_under_a_mesh_s_name_are_refused() {
    let server = server().await;
    for magic in [
        &b"\x89PNG\r\n\x1a\n"[..],
        b"PK\x03\x04",
        b"%PDF-1.7",
        b"\xff\xd8\xff\xe0",
        b"glTF",
        b"?",
    ] {
        let mut bytes = magic.to_vec();
        bytes.resize(80, 0);
        // As a count of triangles, what follows is little after a known beginning, else absurd.
        bytes.extend(if magic == b"?" {
            [0xff; 4]
        } else {
            [9, 0, 0, 0]
        });
        let form = server.post("/meshes").multipart(file(bytes.clone()));
        problem(form.send().await.unwrap(), 415).await;
        let raw = server.post("/meshes").header("content-type", "model/stl");
        problem(raw.body(bytes).send().await.unwrap(), 415).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_refusal_is_short_however_much_is_wrong() {
    let server = server().await;
    let mut many: serde_json::Map<_, _> = (0..5000).map(|n| (format!("k{n}"), json!(1))).collect();
    many.insert(format!("a\u{202e}/{}", "n".repeat(10_000)), json!(1));
    let request = server.post("/jobs").json(&many).send().await.unwrap();
    let refused = problem(request, 422).await;
    assert_eq!(pointers(&refused).len(), 20);
    assert!(pointers(&refused)[0].starts_with("/a\u{fffd}~1nnn"));
    let text = refused.to_string();
    assert!(text.len() < 4000, "{} bytes", text.len());
    assert_eq!(text.matches("accepted are").count(), 1);

    let stray = "--b\r\nContent-Disposition: form-data; name=\"a/b\u{202e}\"\r\n\r\n1\r\n--b--\r\n";
    let request = server.post("/meshes").body(stray);
    let request = request.header("content-type", "multipart/form-data; boundary=b");
    let request = request.send().await;
    let refused = problem(request.unwrap(), 422).await;
    assert_eq!(pointers(&refused), ["/a~1b\u{fffd}"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn faulty_json_is_refused() {
    let server = server().await;
    let deep = format!("{}{}", "[".repeat(200), "]".repeat(200));
    for body in [
        &b""[..],
        b"{",
        b"{} {}",
        b"{\"label\":\"\xff\"}",
        b"{\"seed\":1,\"seed\":2}",
        b"[1,]",
        deep.as_bytes(),
    ] {
        let request = server
            .post("/jobs")
            .header("content-type", "application/json");
        problem(request.body(body.to_vec()).send().await.unwrap(), 400).await;
    }
    let long = format!("{{\"label\":\"{}\"}}", "x".repeat(70_000));
    let request = server
        .post("/jobs")
        .header("content-type", "application/json")
        .body(long.clone());
    problem(request.send().await.unwrap(), 413).await;
    let form = file(small_box()).text("request", long);
    problem(
        server.post("/jobs").multipart(form).send().await.unwrap(),
        413,
    )
    .await;
}

#[tokio::test(flavor = "multi_thread")]
async fn fields_that_cannot_be_used_are_named() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    for (field, value) in [
        ("friction", json!(-0.1)),
        ("contacts", json!(65)),
        ("contacts", json!(0)),
        ("population", json!(0)),
        ("generations", json!(1e9)),
        ("seed", json!("seven")),
        ("label", json!("x".repeat(10_240))),
        ("label", json!("<b>\u{202e}")),
        ("no_such_field", json!(1)),
    ] {
        let body = json!({"mesh_id": mesh, field: value});
        let refused = problem(server.post("/jobs").json(&body).send().await.unwrap(), 422).await;
        assert_eq!(pointers(&refused), [format!("/{field}")]);
        let part = serde_json::to_string(&json!({field: value})).unwrap();
        let form = file(small_box()).part("request", Part::text(part));
        let same = problem(
            server.post("/jobs").multipart(form).send().await.unwrap(),
            422,
        )
        .await;
        assert_eq!(same, refused);
    }
    let form = file(small_box())
        .text("friction", "NaN")
        .text("contacts", "many");
    let refused = problem(
        server.post("/jobs").multipart(form).send().await.unwrap(),
        422,
    )
    .await;
    assert_eq!(pointers(&refused), ["/friction", "/contacts"]);
    for body in [
        json!({}),
        json!({"mesh_id": 7}),
        json!({"mesh_id": "nope"}),
        json!({"mesh_id": "0".repeat(64)}),
    ] {
        let refused = problem(server.post("/jobs").json(&body).send().await.unwrap(), 422).await;
        assert_eq!(pointers(&refused), ["/mesh_id"]);
    }
    assert_eq!(server.json("/jobs").await["jobs"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn query_parameters_are_read_strictly() {
    let server = server().await;
    for query in [
        "/jobs?colour=red",
        "/jobs?limit=1&limit=2",
        "/jobs?limit=0",
        "/jobs?limit=1000000000",
        "/jobs?limit=ten",
        "/jobs?state=asleep",
        "/jobs?cursor=forged",
        "/meshes?cursor=AAAA",
        "/meshes?limit=-1",
        "/meshes?state=queued",
        "/meshes/x?y=1",
        "/jobs/x?y=1",
        "/?y=1",
        "/healthz?y=1",
        "/readyz?y=1",
        "/openapi.json?y=1",
    ] {
        problem(server.get(query).send().await.unwrap(), 400).await;
    }
    let wrong = server
        .post("/meshes?format=gif")
        .multipart(file(small_box()));
    problem(wrong.send().await.unwrap(), 400).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn forms_without_one_file_are_refused() {
    let server = server().await;
    let two = || file(small_box()).part("mesh", Part::bytes(small_box()).file_name("b.stl"));
    for path in ["/jobs", "/meshes"] {
        let request = server.post(path).multipart(Form::new());
        problem(request.send().await.unwrap(), 400).await;
        problem(
            server.post(path).multipart(two()).send().await.unwrap(),
            400,
        )
        .await;
        let request = server
            .post(path)
            .header("content-type", "multipart/form-data")
            .body("x");
        problem(request.send().await.unwrap(), 400).await;
        let request = server
            .post(path)
            .header("content-type", "multipart/form-data; boundary=x");
        problem(request.body("--x\r\nnot a form").send().await.unwrap(), 400).await;
    }
    let request = server
        .post("/jobs")
        .multipart(Form::new().text("contacts", "4"));
    problem(request.send().await.unwrap(), 400).await;
    let both = file(small_box())
        .text("contacts", "4")
        .text("request", "{}");
    problem(
        server.post("/jobs").multipart(both).send().await.unwrap(),
        400,
    )
    .await;
    assert_eq!(server.kept_files(), [""; 0]);
}

#[tokio::test(flavor = "multi_thread")]
async fn forms_with_too_much_around_the_file_are_refused() {
    let server = server().await;
    let many = (0..17).fold(Form::new(), |form, count| {
        form.text(format!("f{count}"), "1")
    });
    problem(
        server.post("/jobs").multipart(many).send().await.unwrap(),
        413,
    )
    .await;
    for (length, pieces) in [(10_000, 1), (10_000, 100), (3_000_000, 100)] {
        let head = format!(
            "--x\r\ncontent-disposition: form-data; name=\"{}\"\r\n\r\n1\r\n--x--\r\n",
            "n".repeat(length)
        );
        let size = head.len().div_ceil(pieces);
        let pieces: Vec<Result<Vec<u8>, std::io::Error>> = head
            .as_bytes()
            .chunks(size)
            .map(|piece| Ok(piece.to_vec()))
            .collect();
        let request = server
            .post("/jobs")
            .header("content-type", "multipart/form-data; boundary=x");
        let body = Body::wrap_stream(futures_util::stream::iter(pieces));
        problem(request.body(body).send().await.unwrap(), 413).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn file_names_are_shown_and_never_paths() {
    let server = server().await;
    let upload = async |name: &str| {
        let head = format!(
            "--b\r\nContent-Disposition: form-data; name=\"mesh\"; filename=\"{name}\"\r\n\r\n"
        );
        let body = [head.as_bytes(), &small_box(), b"\r\n--b--\r\n"].concat();
        let request = server.post("/meshes").body(body);
        let request = request.header("content-type", "multipart/form-data; boundary=b");
        request.send().await.unwrap()
    };
    let long = "n".repeat(256);
    for unfit in ["a\u{202e}b.stl", "a\u{85}b.stl", long.as_str()] {
        let refused = problem(upload(unfit).await, 422).await;
        assert_eq!(pointers(&refused), ["/mesh"]);
    }
    for odd in [
        "../../x.stl",
        "<img onerror=alert(1)>.stl",
        "C:\\x.stl",
        "Körper.stl",
    ] {
        let answer = upload(odd).await;
        assert!(answer.status().is_success(), "{odd}");
    }
    assert_eq!(server.kept_files().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn uploads_over_the_limit_are_refused_and_leave_nothing() {
    let server = server_with(&["--max-upload-bytes", "10000"]).await;
    let long = vec![b'x'; 2_000_000];
    let declared = server.post("/meshes?format=stl").body(long.clone());
    problem(declared.send().await.unwrap(), 413).await;
    for over in [1, 1_000_000] {
        let pieces = long[..10_000 + over]
            .chunks(1000)
            .map(|piece| Ok::<_, std::io::Error>(piece.to_vec()));
        let pieces: Vec<_> = pieces.collect();
        let chunked = server
            .post("/meshes?format=stl")
            .body(Body::wrap_stream(futures_util::stream::iter(pieces)));
        problem(chunked.send().await.unwrap(), 413).await;
    }
    for path in ["/meshes", "/jobs"] {
        let request = server.post(path).multipart(file(long[..10_001].to_vec()));
        problem(request.send().await.unwrap(), 413).await;
    }
    assert_eq!(server.kept_files(), [""; 0]);
    assert_eq!(
        server.get("/healthz").send().await.unwrap().status(),
        StatusCode::OK
    );
}
