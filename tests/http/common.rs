//! A server of its own for each test, and bodies to send it.

use std::time::{Duration, Instant};

use clap::{Args, Command, FromArgMatches};
use graspd::config::Config;
use graspd::http::Application;
use graspd::jobs::{Options, Service};
use reqwest::multipart::{Form, Part};
use reqwest::{Client, RequestBuilder, Response, StatusCode};
use serde_json::Value;
use tempfile::TempDir;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// A server on a free port with a data folder of its own.
pub struct Server {
    pub port: u16,
    pub client: Client,
    pub folder: TempDir,
    pub service: Service,
    stop: Option<oneshot::Sender<()>>,
    done: JoinHandle<()>,
}

/// A server with default settings.
pub async fn server() -> Server {
    server_with(&[]).await
}

/// A server with these flags of `graspd serve` besides.
pub async fn server_with(flags: &[&str]) -> Server {
    server_adjusted(flags, |_| {}).await
}

/// The same, with options that no flag reaches changed.
pub async fn server_adjusted(flags: &[&str], adjust: impl FnOnce(&mut Options)) -> Server {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let fixed = [
        "graspd",
        "--listen",
        "127.0.0.1:0",
        "--data-dir",
        data.to_str().expect("a plain path"),
    ];
    let arguments = fixed.iter().chain(flags);
    let matches = Config::augment_args(Command::new("graspd")).get_matches_from(arguments);
    let config = Config::from_arg_matches(&matches).expect("settings");
    let application = Application::build_with(&config, adjust)
        .await
        .expect("a server");
    let port = application.port();
    let service = application.service().clone();
    let (stop, stopped) = oneshot::channel();
    let done = tokio::spawn(application.run_until_stopped(async {
        let _ = stopped.await;
    }));
    Server {
        port,
        client: Client::builder().no_proxy().build().expect("a client"),
        folder,
        service,
        stop: Some(stop),
        done,
    }
}

impl Server {
    pub fn url(&self, path: &str) -> String {
        format!("http://127.0.0.1:{}{path}", self.port)
    }

    pub fn get(&self, path: &str) -> RequestBuilder {
        self.client.get(self.url(path))
    }

    pub fn post(&self, path: &str) -> RequestBuilder {
        self.client.post(self.url(path))
    }

    pub fn delete(&self, path: &str) -> RequestBuilder {
        self.client.delete(self.url(path))
    }

    pub async fn json(&self, path: &str) -> Value {
        let response = self.get(path).send().await.expect("an answer");
        assert_eq!(response.status(), StatusCode::OK, "{path}");
        response.json().await.expect("JSON")
    }

    /// Uploads a mesh and gives its id.
    pub async fn mesh(&self, bytes: Vec<u8>) -> String {
        let response = self.post("/meshes").multipart(file(bytes)).send().await;
        let report: Value = response.expect("an answer").json().await.expect("JSON");
        report["id"]
            .as_str()
            .unwrap_or_else(|| panic!("{report}"))
            .to_owned()
    }

    /// Submits a job on a mesh that is there and gives its id.
    pub async fn job(&self, mesh_id: &str, mut request: Value) -> String {
        request["mesh_id"] = mesh_id.into();
        let response = self
            .post("/jobs")
            .json(&request)
            .send()
            .await
            .expect("an answer");
        let status = response.status();
        let job: Value = response.json().await.expect("JSON");
        assert_eq!(status, StatusCode::ACCEPTED, "{job}");
        job["id"].as_str().expect("an id").to_owned()
    }

    /// Waits until a job is in one of `states`.
    pub async fn wait_for(&self, job: &str, states: &[&str]) -> Value {
        let end = Instant::now() + Duration::from_secs(60);
        loop {
            let view = self.json(&format!("/jobs/{job}")).await;
            if states.contains(&view["state"].as_str().expect("a state")) {
                return view;
            }
            assert!(Instant::now() < end, "{view} never came to {states:?}");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    /// Files in the data folder other than the database.
    pub fn kept_files(&self) -> Vec<String> {
        let mut files = Vec::new();
        let mut folders = vec![self.folder.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("a folder") {
                let entry = entry.expect("an entry");
                let name = entry.file_name().to_string_lossy().into_owned();
                if entry.file_type().expect("a type").is_dir() {
                    folders.push(entry.path());
                } else if !name.contains(".db")
                    && !name.contains("sqlite")
                    && !name.contains("lock")
                {
                    files.push(name);
                }
            }
        }
        files
    }

    /// Stops the server as SIGTERM does.
    pub async fn stop(mut self) -> TempDir {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
        self.done.await.expect("an orderly end");
        self.folder
    }
}

/// Asserts that an answer is a problem with this status, and gives it.
pub async fn problem(response: Response, status: u16) -> Value {
    let found = response.status();
    let kind = response.headers().get("content-type").cloned();
    let text = response.text().await.expect("a body");
    assert_eq!(found, status, "{text}");
    assert_eq!(kind.expect("a type"), "application/problem+json", "{text}");
    let problem: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(problem["status"], status);
    for member in ["type", "title", "detail"] {
        assert!(
            problem[member]
                .as_str()
                .is_some_and(|text| !text.is_empty()),
            "{text}"
        );
    }
    problem
}

/// The pointers of a problem's field errors.
pub fn pointers(problem: &Value) -> Vec<&str> {
    let errors = problem["errors"].as_array().map_or(&[][..], Vec::as_slice);
    errors
        .iter()
        .filter_map(|error| error["pointer"].as_str())
        .collect()
}

/// A form with a mesh file.
pub fn file(bytes: Vec<u8>) -> Form {
    Form::new().part("mesh", Part::bytes(bytes).file_name("box.stl"))
}

/// An axis-aligned box around the origin as binary STL, each side split into `split`² squares.
pub fn cuboid(sides: [f32; 3], split: u32) -> Vec<u8> {
    let mut triangles: Vec<[[f32; 3]; 3]> = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-0.5, 0.5] {
            let point = |i: u32, j: u32| {
                let mut at = [0.0; 3];
                at[axis] = side * sides[axis];
                at[u] = (i as f32 / split as f32 - 0.5) * sides[u];
                at[v] = (j as f32 / split as f32 - 0.5) * sides[v];
                at
            };
            for (i, j) in (0..split).flat_map(|i| (0..split).map(move |j| (i, j))) {
                let corners = [
                    point(i, j),
                    point(i + 1, j),
                    point(i + 1, j + 1),
                    point(i, j + 1),
                ];
                let [a, b, c, d] = corners;
                if side > 0.0 {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, c, b], [a, d, c]]);
                }
            }
        }
    }
    stl(&triangles)
}

/// A small box that any planner handles in no time.
pub fn small_box() -> Vec<u8> {
    cuboid([1.0, 2.0, 3.0], 4)
}

/// Triangles as binary STL.
pub fn stl(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        for coordinate in triangle.iter().flatten() {
            bytes.extend(coordinate.to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}
