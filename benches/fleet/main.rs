//! Measures the cost of coordination: many workers on one PostgreSQL database, whose planner only waits.
//!
//! `cargo bench --bench fleet -- [JOBS [SERVICES [WORKERS [MILLISECONDS]]]]` prints a Markdown table: so many
//! jobs, so many services in this process, so many workers each, so long a wait; 12,000, 4, 16 and 50 when not
//! given. The cluster is a private one, with all that durability costs. Wants an idle machine.

mod cost;
mod runs;

use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::{Args, Command, FromArgMatches};
use futures_util::future::join_all;
use graspd::config::Config;
use graspd::http::Application;
use reqwest::Client;
use serde_json::{Value, json};
use tempfile::TempDir;
use testkit::postgres::Cluster;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

use cost::Meter;
use runs::Runs;

/// Clients that submit at the same time.
const CLIENTS: usize = 16;
/// Longest time that all jobs together may take.
const PATIENCE: Duration = Duration::from_secs(900);

#[tokio::main]
async fn main() {
    // Cargo adds this when it runs a bench; without it this is a test run, with nothing to measure.
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(at) = arguments.iter().position(|argument| argument == "--bench") else {
        return;
    };
    arguments.remove(at);
    let number = |at: usize, otherwise: usize| {
        let given = arguments.get(at);
        given.map_or(otherwise, |text| text.parse().expect("a number"))
    };
    let (jobs, services, workers) = (number(0, 12_000), number(1, 4), number(2, 16));
    let wait = Duration::from_millis(number(3, 50) as u64);
    measure(jobs, services, workers, wait).await;
}

async fn measure(jobs: usize, services: usize, workers: usize, wait: Duration) {
    let cluster = Cluster::start_with(&["shared_preload_libraries=pg_stat_statements"]);
    let database = cluster.database();
    cluster.ask(&database.name, "CREATE EXTENSION pg_stat_statements");
    let runs = Arc::new(Runs::default());

    let front = Service::start(&database.url, 0, wait, &runs).await;
    let meter = Meter::start(&cluster, &database.name);
    let clock = Instant::now();
    front.submit(jobs).await;
    let submitting = clock.elapsed();
    let submission = meter.stop(jobs);

    let meter = Meter::start(&cluster, &database.name);
    let start = || Service::start(&database.url, workers, wait, &runs);
    let crew = join_all((0..services).map(|_| start())).await;
    let clock = Instant::now();
    while !front.is_idle().await {
        assert!(
            clock.elapsed() < PATIENCE,
            "{} of {jobs} jobs are done",
            runs.count()
        );
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    let work = meter.stop(jobs);
    let connections = cluster.ask(&database.name, cost::CONNECTIONS);
    for service in crew {
        service.stop().await;
    }
    front.stop().await;

    let crowd = services * workers;
    let (busy, window) = runs.busy(crowd);
    println!(
        "| {jobs} jobs of {} ms, {services} services × {workers} workers | |",
        wait.as_millis()
    );
    println!("|---|--:|");
    println!(
        "| busy, while there was work for all | {:.1} % |",
        100.0 * busy
    );
    println!(
        "| claims and finishes a second | {:.0} |",
        jobs as f64 / window.as_secs_f64()
    );
    println!("| runs, of as many jobs | {} |", runs.count());
    println!("| connections | {connections} |");
    println!(
        "| submissions a second, {CLIENTS} clients | {:.0} |",
        jobs as f64 / submitting.as_secs_f64()
    );
    for (what, cost) in [("submission", &submission), ("run", &work)] {
        println!(
            "| database, processor time a {what} | {:.3} ms |",
            cost.database_ms
        );
        println!(
            "| graspd, processor time a {what} | {:.3} ms |",
            cost.graspd_ms
        );
        println!("| transactions a {what} | {:.2} |", cost.transactions);
        println!("| statements a {what} | {:.2} |", cost.statements);
        println!(
            "| write-ahead log a {what} | {:.1} KB |",
            cost.log_bytes / 1e3
        );
        println!("| disk a {what} | {:.1} KB |", cost.disk_bytes / 1e3);
    }
    println!(
        "\n| statements of the runs | calls a job | mean ms | rows a call |\n|---|--:|--:|--:|"
    );
    print!("{}", work.table);
}

/// A service in this process on a free port.
struct Service {
    url: String,
    http: Client,
    stop: oneshot::Sender<()>,
    done: JoinHandle<()>,
    _folder: TempDir,
}

impl Service {
    async fn start(store: &str, workers: usize, wait: Duration, runs: &Arc<Runs>) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let workers = workers.to_string();
        let data = folder.path().join("data");
        let flags = [
            "graspd",
            "--listen",
            "127.0.0.1:0",
            "--store",
            store,
            "--workers",
            &workers,
            "--threads-per-job",
            "1",
            "--queue-capacity",
            "1000000",
            "--data-dir",
            data.to_str().expect("a plain path"),
        ];
        let matches = Config::augment_args(Command::new("graspd")).get_matches_from(flags);
        let config = Config::from_arg_matches(&matches).expect("settings");
        let runner = Arc::clone(runs).runner(wait);
        let application = Application::build_with(&config, |_| {}, Some(runner)).await;
        let application = application.expect("a service");
        let url = format!("http://127.0.0.1:{}", application.port());
        let (stop, stopped) = oneshot::channel();
        let done = tokio::spawn(application.run_until_stopped(async {
            let _ = stopped.await;
        }));
        Self {
            url,
            http: Client::builder().no_proxy().build().expect("a client"),
            stop,
            done,
            _folder: folder,
        }
    }

    /// Submits jobs on one mesh.
    async fn submit(&self, jobs: usize) {
        let mesh = self.http.post(format!("{}/meshes", self.url));
        let mesh = mesh
            .header("content-type", "model/stl")
            .body(testkit::stl::cuboid([1.0, 2.0, 3.0], 4))
            .send();
        let mesh: Value = mesh.await.expect("an answer").json().await.expect("JSON");
        let client = async |client: usize| {
            for seed in (client..jobs).step_by(CLIENTS) {
                let request = json!({
                    "mesh_id": mesh["id"], "seed": seed, "candidates": "triangles", "method": "random",
                });
                let post = self.http.post(format!("{}/jobs", self.url)).json(&request);
                let answer = post.send().await.expect("an answer");
                assert_eq!(answer.status(), 202, "{:?}", answer.text().await);
            }
        };
        join_all((0..CLIENTS).map(client)).await;
    }

    /// Whether no job waits or runs.
    async fn is_idle(&self) -> bool {
        for state in ["queued", "running"] {
            let get = self
                .http
                .get(format!("{}/jobs?state={state}&limit=1", self.url));
            let page: Value = get
                .send()
                .await
                .expect("an answer")
                .json()
                .await
                .expect("JSON");
            if page["jobs"].as_array().is_none_or(|jobs| !jobs.is_empty()) {
                return false;
            }
        }
        true
    }

    async fn stop(self) {
        let _ = self.stop.send(());
        self.done.await.expect("an orderly end");
    }
}
