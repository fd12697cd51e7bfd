//! A server of its own for each test, and bodies to send it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::{Args, Command, FromArgMatches};
use graspd::config::Config;
use graspd::http::Application;
use graspd::jobs::{Options, Runner, Service};
use reqwest::multipart::{Form, Part};
use reqwest::{Client, RequestBuilder, Response, StatusCode};
use serde_json::Value;
use tempfile::TempDir;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

pub use testkit::stl::{cuboid, stl};

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
    start(tempfile::tempdir().expect("a folder"), flags, |_| {}, None).await
}

/// The same, with options that no flag reaches changed.
pub async fn server_adjusted(flags: &[&str], adjust: impl FnOnce(&mut Options)) -> Server {
    start(tempfile::tempdir().expect("a folder"), flags, adjust, None).await
}

/// A server that keeps its data in `folder`, with these flags besides, options changed by `adjust` and, where
/// given, `runner` in the place of the planner.
pub async fn start(
    folder: TempDir,
    flags: &[&str],
    adjust: impl FnOnce(&mut Options),
    runner: Option<Arc<Runner>>,
) -> Server {
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
    let application = Application::build_with(&config, adjust, runner).await;
    let application = application.expect("a server");
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

    /// Begins to stop the server as SIGTERM does.
    pub fn begin_stop(&mut self) {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
    }

    /// Stops the server as SIGTERM does.
    pub async fn stop(mut self) -> TempDir {
        self.begin_stop();
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

/// A small box that any planner handles in no time.
pub fn small_box() -> Vec<u8> {
    cuboid([1.0, 2.0, 3.0], 4)
}
