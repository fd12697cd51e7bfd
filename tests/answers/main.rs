//! What the service answers to some 240 requests, and the command line to `--help`, kept as snapshots: a change that
//! was not meant to change an answer is seen here.
//!
//! The requests stand in `plans.json`, `evaluations.json` and `refusals.json`. Both stores have to answer the same.
//! `INSTA_UPDATE=always cargo test --test answers` writes the snapshots again; then read their diff.

mod shape;

use std::process::Stdio;

use insta::Settings;
use reqwest::Client;
use reqwest::multipart::{Form, Part};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use testkit::postgres::Cluster;
use testkit::process::{Graspd, ended, graspd};

/// Jobs that are submitted before the first of them is waited for.
const AT_ONCE: usize = 16;

/// A planning request: a mesh of `examples/meshes`, and form fields.
#[derive(serde::Deserialize)]
struct Plan {
    #[serde(default)]
    name: String,
    mesh: String,
    settings: std::collections::BTreeMap<String, String>,
}

/// A body of `/evaluations` but for its mesh, which is the box.
#[derive(serde::Deserialize)]
struct Evaluation {
    name: String,
    body: Value,
}

fn requests<T: DeserializeOwned>(text: &str) -> T {
    serde_json::from_str(text).expect("requests")
}

fn mesh(name: &str) -> Vec<u8> {
    std::fs::read(format!("examples/meshes/{name}")).expect("an example mesh")
}

/// Compares an answer with its snapshot in `folder`.
fn compare(folder: &str, name: &str, answer: &str) {
    let mut settings = Settings::clone_current();
    settings.set_snapshot_path(format!("snapshots/{folder}"));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, answer));
}

/// A server and its client.
struct Server {
    process: Graspd,
    client: Client,
    _data: tempfile::TempDir,
}

impl Server {
    /// Starts a server on its embedded store, or on the one at `store`.
    fn start(store: Option<&str>) -> Self {
        let data = tempfile::tempdir().expect("a folder");
        let flags: Vec<&str> = store.iter().flat_map(|url| ["--store", url]).collect();
        Self {
            process: Graspd::start_with(&data.path().join("data"), &flags, Stdio::null()),
            client: Client::builder().no_proxy().build().expect("a client"),
            _data: data,
        }
    }

    async fn answer(request: reqwest::RequestBuilder) -> (u16, Value) {
        let answer = request.send().await.expect("an answer");
        let status = answer.status().as_u16();
        (status, answer.json().await.expect("JSON"))
    }

    async fn get(&self, path: &str) -> (u16, Value) {
        Self::answer(self.client.get(self.process.url(path))).await
    }

    async fn submit(&self, plan: &Plan) -> (u16, Value) {
        let file = Part::bytes(mesh(&plan.mesh)).file_name(plan.mesh.clone());
        let fields = plan.settings.iter();
        let form = fields.fold(Form::new().part("mesh", file), |form, (name, value)| {
            form.text(name.clone(), value.clone())
        });
        Self::answer(self.client.post(self.process.url("/jobs")).multipart(form)).await
    }

    /// Waits for the end of a job; returns its result, or why there is none.
    async fn outcome(&self, id: &str) -> (u16, Value) {
        loop {
            let (_, job) = self.get(&format!("/jobs/{id}?wait=30")).await;
            if !matches!(job["state"].as_str(), Some("queued" | "running")) {
                return self.get(&format!("/jobs/{id}/result")).await;
            }
        }
    }
}

/// Submits every plan and compares its result, or why it was refused.
async fn compare_plans(server: &Server) {
    let plans: Vec<Plan> = requests(include_str!("plans.json"));
    for plans in plans.chunks(AT_ONCE) {
        let mut submitted = Vec::new();
        for plan in plans {
            submitted.push((plan, server.submit(plan).await));
        }
        for (plan, (status, answer)) in submitted {
            let (status, answer) = match answer["id"].as_str() {
                Some(id) if status == 202 => server.outcome(id).await,
                _ => (status, answer),
            };
            compare("plans", &plan.name, &shape::answer(status, &answer));
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn plans_on_the_embedded_store() {
    compare_plans(&Server::start(None)).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn plans_on_postgresql() {
    let url = Cluster::shared().database().url;
    compare_plans(&Server::start(Some(&url))).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn evaluations() {
    let server = Server::start(None);
    let file = Part::bytes(mesh("box.stl")).file_name("box.stl");
    let upload = server.client.post(server.process.url("/meshes"));
    let (_, report) = Server::answer(upload.multipart(Form::new().part("mesh", file))).await;
    compare("meshes", "box", &shape::answer(200, &report));
    for Evaluation { name, mut body } in
        requests::<Vec<Evaluation>>(include_str!("evaluations.json"))
    {
        body["mesh_id"] = report["id"].clone();
        let request = server.client.post(server.process.url("/evaluations"));
        let (status, answer) = Server::answer(request.json(&body)).await;
        compare("evaluations", &name, &shape::answer(status, &answer));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn refusals() {
    let server = Server::start(None);
    let mut answers = String::new();
    for plan in requests::<Vec<Plan>>(include_str!("refusals.json")) {
        let (status, answer) = server.submit(&plan).await;
        let settings = json!(plan.settings);
        answers += &format!("{settings}\n{}\n", shape::refusal(status, &answer));
    }
    compare("refusals", "settings", &answers);
}

#[test]
fn help() {
    let (overview, _) = ended(&graspd(&["--help"]).output().expect("the program"), 0);
    compare("help", "graspd", &overview);
    let commands = overview
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1);
    let names = commands.map_while(|line| line.split_whitespace().next());
    for name in names.filter(|name| *name != "help") {
        let (text, _) = ended(&graspd(&[name, "--help"]).output().expect("the program"), 0);
        compare("help", name, &text);
    }
}
