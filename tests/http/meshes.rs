//! Meshes: upload, list, read, forget.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::common::{cuboid, file, problem, server, server_with, small_box, stl};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

#[tokio::test(flavor = "multi_thread")]
async fn an_upload_is_kept_once_and_reported() {
    let server = server().await;
    let first = server
        .post("/meshes")
        .multipart(file(small_box()))
        .send()
        .await
        .unwrap();
    assert_eq!(first.status(), StatusCode::CREATED);
    let location = first.headers()["location"].to_str().unwrap().to_owned();
    let report: Value = first.json().await.unwrap();
    assert_eq!(
        location,
        format!("/meshes/{}", report["id"].as_str().unwrap())
    );
    let again = server
        .post("/meshes")
        .multipart(file(small_box()))
        .send()
        .await
        .unwrap();
    assert_eq!(again.status(), StatusCode::OK);
    assert_eq!(again.headers()["location"], location.as_str());
    assert_eq!(again.json::<Value>().await.unwrap(), report);
    assert_eq!(server.json(&location).await, report);
    assert_eq!(
        server.json("/meshes").await["meshes"]
            .as_array()
            .unwrap()
            .len(),
        1
    );
    assert_eq!(server.kept_files().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn raw_bodies_are_read_by_type_or_format() {
    let server = server().await;
    for (path, kind, body) in [
        ("/meshes", Some("model/stl"), small_box()),
        (
            "/meshes",
            Some("application/octet-stream"),
            cuboid([1.0, 1.0, 2.0], 2),
        ),
        ("/meshes", Some("model/obj"), OBJ.into()),
        ("/meshes?format=stl", None, cuboid([1.0, 1.0, 3.0], 2)),
        (
            "/meshes?format=obj",
            Some("application/x-www-form-urlencoded"),
            format!("# b\n{OBJ}").into(),
        ),
    ] {
        let mut request = server.post(path).body(body);
        if let Some(kind) = kind {
            request = request.header("content-type", kind);
        }
        let answer = request.send().await.unwrap();
        assert_eq!(
            answer.status(),
            StatusCode::CREATED,
            "{path} {kind:?}: {}",
            answer.text().await.unwrap()
        );
    }
    assert_eq!(
        server.json("/meshes").await["meshes"]
            .as_array()
            .unwrap()
            .len(),
        5
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn files_of_several_megabytes_are_taken_in_every_way() {
    let server = server().await;
    let large = cuboid([1.0, 2.0, 3.0], 100);
    assert!(large.len() > 5_000_000);
    let raw = server.post("/meshes?format=stl").body(large.clone());
    assert_eq!(raw.send().await.unwrap().status(), StatusCode::CREATED);
    let form = server.post("/meshes").multipart(file(large));
    assert_eq!(form.send().await.unwrap().status(), StatusCode::OK);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_report_has_an_entity_tag() {
    let server = server().await;
    let id = server.mesh(small_box()).await;
    let path = format!("/meshes/{id}");
    let tag = server.get(&path).send().await.unwrap().headers()["etag"].clone();
    for known in [
        tag.to_str().unwrap(),
        "*",
        &format!("\"x\", W/{}", tag.to_str().unwrap()),
    ] {
        let answer = server
            .get(&path)
            .header("if-none-match", known)
            .send()
            .await
            .unwrap();
        assert_eq!(answer.status(), StatusCode::NOT_MODIFIED);
        assert_eq!(answer.headers()["etag"], tag);
        assert!(answer.bytes().await.unwrap().is_empty());
    }
    let other = server
        .get(&path)
        .header("if-none-match", "\"x\"")
        .send()
        .await
        .unwrap();
    assert_eq!(other.status(), StatusCode::OK);
}

#[tokio::test(flavor = "multi_thread")]
async fn lists_come_in_pages_newest_first() {
    let server = server().await;
    let mut ids = Vec::new();
    for height in 1..=5 {
        ids.push(server.mesh(cuboid([1.0, 1.0, height as f32], 2)).await);
    }
    let mut found = Vec::new();
    let mut path = "/meshes?limit=2".to_owned();
    loop {
        let page = server.json(&path).await;
        let items = page["meshes"].as_array().unwrap();
        assert!(items.len() <= 2);
        found.extend(
            items
                .iter()
                .map(|item| item["id"].as_str().unwrap().to_owned()),
        );
        match page["next_cursor"].as_str() {
            Some(cursor) => path = format!("/meshes?limit=2&cursor={cursor}"),
            None => break,
        }
    }
    ids.reverse();
    assert_eq!(found, ids);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_is_deleted_with_its_file() {
    let server = server().await;
    let id = server.mesh(small_box()).await;
    let path = format!("/meshes/{id}");
    let answer = server.delete(&path).send().await.unwrap();
    assert_eq!(answer.status(), StatusCode::NO_CONTENT);
    problem(server.get(&path).send().await.unwrap(), 404).await;
    problem(server.delete(&path).send().await.unwrap(), 404).await;
    assert_eq!(server.kept_files(), [""; 0]);
}

#[tokio::test(flavor = "multi_thread")]
async fn files_that_are_no_mesh_are_refused_and_leave_nothing() {
    let server = server_with(&["--max-triangles", "1000"]).await;
    let flat = stl(&[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 2]);
    let degenerate = stl(&[[[0.0; 3]; 3]; 4]);
    let not_a_number = stl(&[[[f32::NAN; 3]; 3]; 4]);
    let sound = small_box();
    for (status, bytes) in [
        (415, b"GIF89a, surely no mesh".to_vec()),
        (422, stl(&[])),
        (422, degenerate),
        (422, flat),
        (422, not_a_number),
        (422, cuboid([1.0; 3], 20)),
    ] {
        for path in ["/meshes", "/jobs"] {
            let answer = server
                .post(path)
                .multipart(file(bytes.clone()))
                .send()
                .await
                .unwrap();
            problem(answer, status).await;
        }
    }
    for bytes in [
        Vec::new(),
        sound[..sound.len() - 20].to_vec(),
        b"v 0 0 0\nf 1 2 900\n".to_vec(),
    ] {
        let answer = server
            .post("/meshes")
            .multipart(file(bytes))
            .send()
            .await
            .unwrap();
        let status = answer.status().as_u16();
        assert!([415, 422].contains(&status), "{status}");
        problem(answer, status).await;
    }
    assert_eq!(server.json("/meshes").await["meshes"], json!([]));
    assert_eq!(server.json("/jobs").await["jobs"], json!([]));
    assert_eq!(server.kept_files(), [""; 0]);
}
