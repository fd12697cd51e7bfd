//! Given grasps, evaluated at once: over HTTP, and the same from the command line.

use std::io::Write as _;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use reqwest::StatusCode;
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use crate::common::{Server, cuboid, file, pointers, problem, server, server_with, small_box, stl};

mod answers;
mod command;
mod forces;
mod refusals;

/// Triangles of [`small_box`].
const TRIANGLES: usize = 6 * 4 * 4 * 2;

async fn evaluate(server: &Server, body: &Value) -> Vec<u8> {
    let answer = server.post("/evaluations").json(body).send().await.unwrap();
    let status = answer.status();
    let bytes = answer.bytes().await.unwrap().to_vec();
    assert_eq!(
        status,
        StatusCode::OK,
        "{}",
        String::from_utf8_lossy(&bytes)
    );
    bytes
}

async fn evaluations(server: &Server, body: &Value) -> Value {
    serde_json::from_slice(&evaluate(server, body).await).unwrap()
}

async fn refused(server: &Server, body: &Value, status: u16) -> Value {
    let answer = server.post("/evaluations").json(body).send().await.unwrap();
    problem(answer, status).await
}

/// `graspd evaluate` on a mesh file, grasps on its standard input.
fn command(mesh: &std::path::Path, grasps: &str, flags: &[&str]) -> Output {
    let mut child = Command::new(testkit::process::binary())
        .arg("evaluate")
        .arg(mesh)
        .arg("-")
        .args(flags)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    // A command that refuses its flags reads nothing.
    let _ = input.write_all(grasps.as_bytes());
    drop(input);
    child.wait_with_output().unwrap()
}

/// Seven triangles of the box that differ with `n`, the seventh of them with all of its digits.
fn seven(n: usize) -> Vec<Value> {
    (0..7)
        .map(|finger| json!({"triangle": (n * 31 + finger * 29 + finger * finger) % TRIANGLES}))
        .collect()
}

/// Contacts on four sides of the box that hold it with friction.
fn four() -> Value {
    json!([
        {"point": [0.6, 0.1, 0.2]}, {"point": [-0.6, -0.2, 0.1]},
        {"point": [0.1, 1.2, -0.3]}, {"point": [-0.1, -1.2, 0.2]}
    ])
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn vector(value: &Value) -> [f64; 3] {
    serde_json::from_value(value.clone()).unwrap_or_else(|_| panic!("{value} is no vector"))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn close(a: &Value, b: &Value) -> bool {
    (number(a) - number(b)).abs() <= 1e-9 * number(a).abs()
}
