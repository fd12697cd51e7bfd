//! Pictures of grasps and searches.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::common::{Server, problem, server, server_with, small_box};

impl Server {
    /// A job on the box that has ended.
    async fn ended(&self, request: Value) -> (String, String) {
        let mesh = self.mesh(small_box()).await;
        let job = self.job(&mesh, request).await;
        self.wait_for(&job, &["succeeded", "failed", "cancelled"])
            .await;
        (mesh, job)
    }

    /// The bytes of a file of some kind.
    async fn drawn(&self, path: &str, kind: &str) -> Vec<u8> {
        let answer = self.get(path).send().await.unwrap();
        assert_eq!(answer.status(), StatusCode::OK, "{path}");
        assert_eq!(answer.headers()["content-type"], kind, "{path}");
        answer.bytes().await.unwrap().to_vec()
    }
}

/// Width and height of a PNG.
fn size(png: &[u8]) -> (u32, u32) {
    let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info();
    let reader = reader.unwrap();
    (reader.info().width, reader.info().height)
}

fn small() -> Value {
    json!({"generations": 2, "seed": 1, "top": 2})
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_has_ended_is_drawn() {
    let server = server().await;
    let (_, job) = server.ended(small()).await;
    let picture = |rest: &str| format!("/jobs/{job}/{rest}");
    let png = server.drawn(&picture("grasp.png"), "image/png").await;
    let (width, height) = size(&png);
    assert!(width == 1024 && height > 600, "{width} {height}");
    let again = server.drawn(&picture("grasp.png"), "image/png").await;
    assert!(png == again, "the same bytes");
    let thumbnail = picture("grasp.png?width=192&view=iso&legend=false&theme=dark");
    let thumbnail = server.drawn(&thumbnail, "image/png").await;
    assert_eq!(size(&thumbnail), (192, 144));
    let mut pictures = vec![png];
    for grasp in ["initial", "2"] {
        let path = picture(&format!("grasp.png?grasp={grasp}"));
        pictures.push(server.drawn(&path, "image/png").await);
    }
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
    let svg = server
        .drawn(&picture("grasp.svg?view=30,20"), "image/svg+xml")
        .await;
    assert!(svg.starts_with(b"<svg ") && svg.ends_with(b"</svg>\n"));
    let curve = server
        .drawn(&picture("convergence.png?width=400"), "image/png")
        .await;
    assert_eq!(size(&curve).0, 400);
    let curve = server
        .drawn(&picture("convergence.svg"), "image/svg+xml")
        .await;
    assert!(curve.starts_with(b"<svg "));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cached_picture_is_not_sent_again() {
    let server = server().await;
    let (_, job) = server.ended(small()).await;
    let mut tags = Vec::new();
    for rest in [
        "grasp.png",
        "grasp.png?view=top",
        "grasp.png?theme=dark",
        "grasp.png?width=64",
        "grasp.png?legend=false",
        "grasp.png?grasp=initial",
        "grasp.svg",
        "convergence.png",
        "convergence.svg",
        "convergence.svg?theme=dark",
    ] {
        let path = format!("/jobs/{job}/{rest}");
        let first = server.get(&path).send().await.unwrap();
        let tag = first.headers()["etag"].to_str().unwrap().to_owned();
        let second = server
            .get(&path)
            .header("if-none-match", &tag)
            .send()
            .await
            .unwrap();
        assert_eq!(second.status(), StatusCode::NOT_MODIFIED, "{rest}");
        assert!(!tags.contains(&tag), "{rest}");
        tags.push(tag);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_drawn_is_refused() {
    let server = server().await;
    let (mesh, job) = server.ended(small()).await;
    for wrong in [
        "grasp.png?width=63",
        "grasp.png?width=4097",
        "grasp.png?view=up",
        "grasp.png?view=0,91",
        "grasp.png?legend=1",
        "grasp.png?grasp=0",
        "grasp.png?grasp=worst",
        "grasp.png?color=red",
        "grasp.png?view=top&view=top",
        "grasp.svg?theme=blue",
        "convergence.png?view=top",
        "convergence.svg?width=100",
    ] {
        let answer = server
            .get(&format!("/jobs/{job}/{wrong}"))
            .send()
            .await
            .unwrap();
        problem(answer, 400).await;
    }
    let missing = server
        .get(&format!("/jobs/{job}/grasp.png?grasp=3"))
        .send()
        .await
        .unwrap();
    problem(missing, 409).await;
    for path in [
        "grasp.png",
        "grasp.svg",
        "convergence.png",
        "convergence.svg",
    ] {
        let unknown = format!("/jobs/01a20203-4fd6-77c7-b546-6eed63910d31/{path}");
        problem(server.get(&unknown).send().await.unwrap(), 404).await;
        let unwanted = server
            .get(&format!("/jobs/{job}/{path}"))
            .header("accept", "text/html");
        problem(unwanted.send().await.unwrap(), 406).await;
    }
    let gone = server
        .delete(&format!("/meshes/{mesh}"))
        .send()
        .await
        .unwrap();
    assert_eq!(gone.status(), StatusCode::NO_CONTENT);
    let answer = server
        .get(&format!("/jobs/{job}/grasp.svg"))
        .send()
        .await
        .unwrap();
    problem(answer, 410).await;
    let curve = format!("/jobs/{job}/convergence.svg");
    server.drawn(&curve, "image/svg+xml").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_without_a_result_has_no_picture() {
    let server = server_with(&["--workers", "1"]).await;
    let mesh = server.mesh(small_box()).await;
    let long = json!({"method": "modified_ga", "population": 1000, "generations": 100_000});
    let running = server.job(&mesh, long.clone()).await;
    let waiting = server.job(&mesh, long).await;
    server.wait_for(&running, &["running"]).await;
    for job in [&running, &waiting] {
        let answer = server
            .get(&format!("/jobs/{job}/grasp.png"))
            .send()
            .await
            .unwrap();
        assert!(answer.headers().contains_key("retry-after"));
        problem(answer, 409).await;
    }
    let cancel = format!("/jobs/{waiting}/cancel");
    server.post(&cancel).send().await.unwrap();
    server.wait_for(&waiting, &["cancelled"]).await;
    let answer = server
        .get(&format!("/jobs/{waiting}/convergence.png"))
        .send()
        .await
        .unwrap();
    assert!(!answer.headers().contains_key("retry-after"));
    problem(answer, 409).await;
    server
        .post(&format!("/jobs/{running}/cancel"))
        .send()
        .await
        .unwrap();
    server.wait_for(&running, &["cancelled", "succeeded"]).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_nearest_miss_is_drawn_with_the_reason() {
    let server = server().await;
    let words = "</svg><script>alert(1)</script>";
    // The first random grasp of a box without friction holds nothing.
    let request = json!({
        "contact_model": "frictionless", "method": "random", "evaluation_limit": 1, "seed": 1, "label": words,
    });
    let (_, job) = server.ended(request).await;
    let result = server.json(&format!("/jobs/{job}/result")).await;
    assert_eq!(result["force_closure"], false);
    assert_eq!(result["contacts"].as_array().map(Vec::len), Some(7));
    let answer = server
        .get(&format!("/jobs/{job}/grasp.svg"))
        .send()
        .await
        .unwrap();
    let svg = answer.text().await.unwrap();
    assert!(svg.contains("no force closure") && !svg.contains("<script"));
}
