//! Servers and workers on one database.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use reqwest::{Client, Method, RequestBuilder};
use serde_json::Value;
use tempfile::TempDir;
use testkit::postgres::{Cluster, Database};
use testkit::stl::cuboid;

use crate::member::{Member, Role};

/// Longest that a job or a process is waited for, on a machine that is busy with other tests.
pub const PATIENCE: Duration = Duration::from_secs(120);
/// Pause between two looks.
const PAUSE: Duration = Duration::from_millis(50);

/// A small fleet whose members come and go as the test says. They are killed when this is dropped.
pub struct Fleet {
    pub servers: Vec<Member>,
    pub workers: Vec<Member>,
    pub database: Database,
    pub http: Client,
    /// Sent along as the key of a client, where the servers want one.
    pub key: Option<String>,
    folder: TempDir,
}

impl Fleet {
    /// Servers with these flags on a new database of the shared cluster. No worker runs yet.
    pub fn start(servers: usize, flags: &[&str]) -> Self {
        let database = Cluster::shared().database();
        let folder = tempfile::tempdir().expect("a folder");
        let place = |number: usize| folder.path().join(format!("server-{number}"));
        let new = |number| Member::new(Role::Server, &database.url, place(number), flags);
        let mut servers: Vec<Member> = (0..servers).map(new).collect();
        servers.iter_mut().for_each(Member::start);
        Self {
            servers,
            workers: Vec::new(),
            database,
            http: Client::builder().no_proxy().build().expect("a client"),
            key: None,
            folder,
        }
    }

    /// Starts one more worker.
    pub fn hire(&mut self) {
        let store = self.database.url.clone();
        self.hire_at(&store);
    }

    /// Starts one more worker, which reaches the database at this URL.
    pub fn hire_at(&mut self, store: &str) {
        let number = self.workers.len();
        let place = self.folder.path().join(format!("worker-{number}"));
        let mut worker = Member::new(Role::Worker, store, place, &[]);
        worker.start();
        self.workers.push(worker);
    }

    /// The logs of the workers, in their order.
    pub fn logs(&self) -> Vec<PathBuf> {
        self.workers.iter().map(Member::log).collect()
    }

    /// Carries out SQL on the database.
    pub fn ask(&self, sql: &str) -> String {
        Cluster::shared().ask(&self.database.name, sql)
    }

    /// A request to one of the servers.
    pub fn request(&self, server: usize, method: Method, path: &str) -> RequestBuilder {
        let url = format!("{}{path}", self.servers[server].url);
        let request = self.http.request(method, url);
        match &self.key {
            Some(key) => request.bearer_auth(key),
            None => request,
        }
    }

    /// What one of the servers answers, with its status.
    pub async fn answer(&self, request: RequestBuilder) -> (u16, Value) {
        let answer = request.send().await.expect("an answer");
        let status = answer.status().as_u16();
        (status, answer.json().await.unwrap_or_default())
    }

    /// Uploads a mesh file and gives the id of the mesh.
    pub async fn mesh(&self, server: usize, bytes: Vec<u8>) -> String {
        let request = self.request(server, Method::POST, "/meshes");
        let request = request.header("content-type", "model/stl").body(bytes);
        let (_, report) = self.answer(request).await;
        let id = report["id"].as_str();
        id.unwrap_or_else(|| panic!("{report}")).to_owned()
    }

    /// Uploads a small box.
    pub async fn small_box(&self, server: usize) -> String {
        self.mesh(server, cuboid([1.0, 2.0, 3.0], 4)).await
    }

    /// Submits a job and gives its id.
    pub async fn job(&self, server: usize, request: &Value) -> String {
        let post = self.request(server, Method::POST, "/jobs").json(request);
        let (status, job) = self.answer(post).await;
        assert_eq!(status, 202, "{job}");
        job["id"].as_str().expect("an id").to_owned()
    }

    /// A job as one of the servers has it.
    pub async fn view(&self, server: usize, job: &str) -> Value {
        let path = format!("/jobs/{job}");
        let (status, view) = self.answer(self.request(server, Method::GET, &path)).await;
        assert_eq!(status, 200, "{view}");
        view
    }

    /// Waits until a job is in one of `states`.
    pub async fn wait_for(&self, server: usize, job: &str, states: &[&str]) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            let view = self.view(server, job).await;
            if states.contains(&view["state"].as_str().expect("a state")) {
                return view;
            }
            assert!(Instant::now() < end, "{view} never came to {states:?}");
            tokio::time::sleep(PAUSE).await;
        }
    }

    /// Ends all members in order and asserts that they end well.
    pub fn stop(mut self) {
        for member in self.workers.iter_mut().chain(&mut self.servers) {
            let status = member.end("-TERM");
            assert!(status.success(), "{:?}: {status}", member.role);
        }
    }
}

/// Waits until something happens.
pub async fn until(what: &str, mut happens: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !happens() {
        assert!(Instant::now() < end, "never: {what}");
        tokio::time::sleep(PAUSE).await;
    }
}
