//! The calls that the measurements make.

use std::time::{Duration, Instant};

use reqwest::{Client, Response};
use serde_json::{Value, json};

/// Longest time to wait for one job.
const PATIENCE: Duration = Duration::from_secs(60);
/// Pause between two looks at a job, where the server does not wait itself.
const POLL: Duration = Duration::from_millis(2);

/// A server with a mesh on it.
#[derive(Clone)]
pub struct Api {
    http: Client,
    url: String,
    mesh: String,
}

impl Api {
    /// Uploads the box of the examples.
    pub async fn new(url: &str) -> Self {
        let http = Client::builder()
            .no_proxy()
            .timeout(PATIENCE)
            .pool_max_idle_per_host(128)
            .build();
        let mut api = Self {
            http: http.expect("a client"),
            url: url.trim_end_matches('/').to_owned(),
            mesh: String::new(),
        };
        api.mesh = api.upload(0).await;
        api
    }

    /// The same with a mesh of its own: the box in a file that differs by `number`.
    pub async fn with_mesh(&self, number: u32) -> Self {
        Self {
            mesh: self.upload(number).await,
            ..self.clone()
        }
    }

    async fn upload(&self, number: u32) -> String {
        let mut bytes = std::fs::read("examples/meshes/box.stl").expect("the box of the examples");
        // The last bytes of the head of a binary STL mean nothing.
        bytes[76..80].copy_from_slice(&number.to_le_bytes());
        let upload = self.http.post(format!("{}/meshes", self.url));
        let upload = upload.header("content-type", "model/stl").body(bytes);
        let mesh = json_of(upload.send().await.expect("an answer")).await;
        mesh["id"].as_str().expect("a mesh").to_owned()
    }

    /// A job that is over as soon as it has begun.
    pub fn tiny(&self, seed: usize) -> Value {
        self.request(seed, 2, 1)
    }

    /// A job that does not end by itself.
    pub fn endless(&self, seed: usize) -> Value {
        self.request(seed, 10_000, 90_000)
    }

    fn request(&self, seed: usize, population: u32, generations: u32) -> Value {
        json!({
            "mesh_id": self.mesh, "seed": seed, "candidates": "triangles", "method": "random",
            "population": population, "generations": generations,
        })
    }

    /// Submits a job, whatever is answered.
    pub async fn submit(&self, request: &Value, key: Option<&str>) -> reqwest::Result<Response> {
        let mut post = self.http.post(format!("{}/jobs", self.url)).json(request);
        if let Some(key) = key {
            post = post.header("idempotency-key", key);
        }
        post.send().await
    }

    /// Submits a job that must be accepted, and gives its id.
    pub async fn accepted(&self, request: &Value) -> String {
        let answer = self.submit(request, None).await.expect("an answer");
        let status = answer.status();
        let job = json_of(answer).await;
        assert_eq!(status, 202, "{job}");
        job["id"].as_str().expect("an id").to_owned()
    }

    pub async fn get(&self, path: &str) -> Response {
        let get = self.http.get(format!("{}{path}", self.url));
        get.send().await.expect("an answer")
    }

    pub async fn cancel(&self, job: &str) {
        let post = self.http.post(format!("{}/jobs/{job}/cancel", self.url));
        let status = post.send().await.expect("an answer").status();
        assert!(status.is_success(), "{status}");
    }

    /// Waits for the end of a job: by asking again and again, or by having the server wait.
    pub async fn ended(&self, job: &str, wait: bool) -> Value {
        let end = Instant::now() + PATIENCE;
        let path = format!("/jobs/{job}{}", if wait { "?wait=20" } else { "" });
        loop {
            let view = json_of(self.get(&path).await).await;
            if !["queued", "running"].contains(&view["state"].as_str().expect("a state")) {
                return view;
            }
            assert!(Instant::now() < end, "{view} does not end");
            if !wait {
                tokio::time::sleep(POLL).await;
            }
        }
    }
}

/// The body of an answer.
pub async fn json_of(answer: Response) -> Value {
    answer.json().await.expect("JSON")
}
