//! `graspd batch`: interrupted, killed, cut off, and in the end each mesh is planned once.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use reqwest::Client;
use serde_json::Value;
use testkit::process::{Graspd, ended, get, graspd};

use crate::common::{cuboid, stl};

/// Settings that a planner has done with in milliseconds.
const QUICK: [&str; 6] = [
    "--method",
    "local",
    "--generations",
    "3",
    "--population",
    "10",
];

/// Boxes of different sizes, so many of them, in a folder.
fn variants(folder: &Path, count: u32) -> Vec<PathBuf> {
    fs::create_dir_all(folder).unwrap();
    let write = |number: u32| {
        let path = folder.join(format!("box-{number}.stl"));
        let sides = [1.0 + number as f32 / 1000.0, 1.2, 1.5];
        fs::write(&path, cuboid(sides, 3)).unwrap();
        path
    };
    (0..count).map(write).collect()
}

fn batch(server: &str, output: &Path, files: &[PathBuf]) -> Command {
    let mut command = graspd(&["batch", "--server", server, "--output"]);
    command.arg(output).args(QUICK).args(files);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Results in a folder by their names.
fn written(folder: &Path) -> HashMap<String, Value> {
    let Ok(entries) = fs::read_dir(folder) else {
        return HashMap::new();
    };
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let results = names.filter(|name| name.ends_with(".json"));
    let read = |name: String| {
        let text = fs::read_to_string(folder.join(&name)).unwrap();
        // Never half of one.
        let result = serde_json::from_str(&text).unwrap();
        (name, result)
    };
    results.map(read).collect()
}

/// Waits until so many results are written while the command runs.
fn until(command: &mut Child, folder: &Path, results: usize) {
    let end = Instant::now() + Duration::from_secs(120);
    while written(folder).len() < results {
        assert!(command.try_wait().unwrap().is_none(), "it has ended");
        assert!(Instant::now() < end);
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn send(signal: &str, command: &Child) {
    let sent = Command::new("kill")
        .args([signal, &command.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
}

/// All jobs of a server, without their results.
async fn jobs(client: &Client, server: &Graspd) -> Vec<Value> {
    let (mut jobs, mut cursor) = (Vec::new(), String::new());
    loop {
        let page = get(client, server.url(&format!("/jobs?limit=1000{cursor}"))).await;
        jobs.extend(page["jobs"].as_array().unwrap().clone());
        match page["next_cursor"].as_str() {
            Some(next) => cursor = format!("&cursor={next}"),
            None => return jobs,
        }
    }
}

fn rows(folder: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(folder.join("summary.csv")).unwrap();
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().skip(1).map(cells).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn five_hundred_meshes_are_each_planned_once_whatever_is_killed() {
    const MESHES: usize = 500;
    let place = tempfile::tempdir().unwrap();
    let (data, output) = (place.path().join("data"), place.path().join("results"));
    let files = variants(&place.path().join("meshes"), MESHES as u32);
    // Less room in the queue than the command has jobs under way.
    let flags = ["--queue-capacity", "8", "--workers", "2"];
    let mut server = Graspd::start_with(&data, &flags, Stdio::null());
    let start = |server: &Graspd| batch(&server.url, &output, &files).spawn().unwrap();

    let mut command = start(&server);
    until(&mut command, &output, 60);
    send("-INT", &command);
    let (_, stderr) = ended(&command.wait_with_output().unwrap(), 130);
    assert!(
        stderr.contains("interrupted") && stderr.contains("the same command"),
        "{stderr}"
    );
    assert!(written(&output).len() < MESHES);

    let mut command = start(&server);
    until(&mut command, &output, 150);
    command.kill().unwrap();
    command.wait().unwrap();
    assert!(written(&output).len() < MESHES);

    // The server dies while the command goes on, and comes back on the same port.
    let mut command = start(&server);
    until(&mut command, &output, 280);
    let address = server.url.trim_start_matches("http://").to_owned();
    server.signal("-KILL");
    drop(server);
    std::thread::sleep(Duration::from_millis(300));
    assert!(command.try_wait().unwrap().is_none(), "it waits");
    let again = [&flags[..], &["--listen", &address]].concat();
    let mut binary = graspd(&["serve", "--data-dir"]);
    binary.arg(&data).args(again).stderr(Stdio::null());
    let server = Graspd::launch(&mut binary);
    let (table, _) = ended(&command.wait_with_output().unwrap(), 0);
    assert!(table.contains("500 meshes: 500 succeeded"), "{table}");

    let client = Client::builder().no_proxy().build().unwrap();
    let jobs = jobs(&client, &server).await;
    assert_eq!(jobs.len(), MESHES, "each was planned once");
    let results = written(&output);
    assert_eq!(results.len(), MESHES);
    let by_label: HashMap<&str, &Value> = jobs
        .iter()
        .map(|job| (job["label"].as_str().unwrap(), job))
        .collect();
    assert_eq!(by_label.len(), MESHES);
    for (name, result) in &results {
        let job = by_label[name.strip_suffix(".json").unwrap()];
        let id = job["id"].as_str().unwrap();
        let kept = client
            .get(server.url(&format!("/jobs/{id}/result")))
            .send()
            .await
            .unwrap();
        let kept = kept.bytes().await.unwrap();
        assert_eq!(kept, fs::read(output.join(name)).unwrap(), "{name}");
        assert_eq!(result["seed"], job["request"]["seed"]);
        assert_eq!(job["priority"], "batch");
    }
    let meshes: HashSet<&str> = jobs
        .iter()
        .map(|job| job["mesh_id"].as_str().unwrap())
        .collect();
    assert_eq!(meshes.len(), MESHES);
    let rows = rows(&output);
    assert_eq!(rows.len(), MESHES);
    for (row, file) in rows.iter().zip(&files) {
        assert_eq!(row[0], file.display().to_string());
        let result = &results[&row[1]];
        assert_eq!((row[2].as_str(), row[3].as_str()), ("succeeded", "true"));
        let quality: f64 = row[4].parse().unwrap();
        assert!((quality - result["quality"].as_f64().unwrap()).abs() < 1e-6);
    }

    // Nothing is left to do, and nothing is done.
    let again = start(&server).wait_with_output().unwrap();
    ended(&again, 0);
}

fn run(mut command: Command) -> Output {
    command.output().unwrap()
}

#[test]
fn each_file_is_reported_separately_and_other_settings_are_refused() {
    let place = tempfile::tempdir().unwrap();
    let path = |name: &str| place.path().join(name);
    let server = Graspd::start(&path("data"));
    let mut files = variants(&path("a"), 2);
    files.extend(variants(&path("b"), 1));
    // Another box under the name of the first.
    fs::write(&files[2], cuboid([2.0, 2.5, 3.0], 3)).unwrap();
    let flat = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
    fs::write(path("flat.stl"), stl(&flat)).unwrap();
    files.extend([path("flat.stl"), path("none.stl"), files[0].clone()]);
    let output = path("results");
    let (table, stderr) = ended(&run(batch(&server.url, &output, &files)), 1);
    assert!(
        table.contains("5 meshes: 3 succeeded, 1 refused, 1 unreadable"),
        "{table}"
    );
    assert!(
        stderr.contains("flat.stl: refused: The mesh cannot be used"),
        "{stderr}"
    );
    let names: HashSet<String> = written(&output).into_keys().collect();
    let expected = ["box-0.stl.json", "box-1.stl.json", "box-0.stl-2.json"];
    assert_eq!(names, expected.map(str::to_owned).into());
    let rows = rows(&output);
    assert_eq!(
        (rows[0][1].as_str(), rows[2][1].as_str()),
        (expected[0], expected[2])
    );

    let mut other = batch(&server.url, &output, &files);
    other.args(["--contacts", "5"]);
    let (_, stderr) = ended(&run(other), 2);
    assert!(stderr.contains("contacts: 4 there, 5 here"), "{stderr}");
    // A file that is there now, one that has changed, and one whose result is gone.
    fs::write(path("none.stl"), cuboid([3.0, 2.0, 2.5], 3)).unwrap();
    fs::write(&files[1], cuboid([4.0, 2.0, 2.5], 3)).unwrap();
    let before = fs::read(output.join(expected[0])).unwrap();
    fs::remove_file(output.join(expected[0])).unwrap();
    fs::remove_file(&files[3]).unwrap();
    fs::write(&files[3], cuboid([1.5, 2.0, 2.5], 3)).unwrap();
    let changed = fs::read(output.join(expected[1])).unwrap();
    ended(&run(batch(&server.url, &output, &files)), 0);
    assert_eq!(written(&output).len(), 5);
    assert_eq!(fs::read(output.join(expected[0])).unwrap(), before);
    assert_ne!(fs::read(output.join(expected[1])).unwrap(), changed);

    // A surface of revolution would do; fewer contacts than a grasp needs do too.
    let mut hopeless = batch(&server.url, &path("hopeless"), &files[..1]);
    hopeless.args(["--contacts", "1"]);
    let (table, _) = ended(&run(hopeless), 3);
    assert!(table.contains("false"), "{table}");
}

#[test]
fn impossible_arguments_are_refused_at_once() {
    let place = tempfile::tempdir().unwrap();
    let files = variants(&place.path().join("a"), 1);
    let output = place.path().join("results");
    let refused = |flags: &[&str], code: i32, words: &str| {
        let mut command = graspd(&["batch", "--output"]);
        command.arg(&output).args(&files).args(flags);
        let (_, stderr) = ended(&run(command), code);
        assert!(stderr.contains(words), "{stderr}");
    };
    refused(&["--server", "localhost:1"], 2, "http");
    refused(
        &["--server", "http://127.0.0.1:1", "--in-flight", "0"],
        2,
        "from 1 to 256",
    );
    refused(
        &["--server", "http://127.0.0.1:1", "--contacts", "65"],
        2,
        "--contacts",
    );
    refused(
        &["--server", "http://127.0.0.1:1", "--patience", "1"],
        1,
        "no answer from http://127.0.0.1:1",
    );
    let server = Graspd::start_with(
        &place.path().join("data"),
        &["--auth", "keys"],
        Stdio::null(),
    );
    refused(&["--server", &server.url], 1, "API key");
}
