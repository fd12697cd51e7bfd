//! From a mesh file to printed contacts, over HTTP:
//!
//! ```text
//! cargo run --release --example client -- http://127.0.0.1:8080 examples/meshes/duck.obj contacts=4 friction=0.5
//! ```
//!
//! Everything after the file is a planning setting, sent as a field of the form.

use std::error::Error;
use std::time::Duration;

use reqwest::header::{LOCATION, RETRY_AFTER};
use reqwest::multipart::{Form, Part};
use reqwest::{Client, Response};
use serde_json::Value;

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(server), Some(path)) = (arguments.next(), arguments.next()) else {
        return Err("usage: client SERVER MESH [NAME=VALUE]...".into());
    };
    let name = std::path::Path::new(&path)
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    let mut form = Form::new().part("mesh", Part::bytes(std::fs::read(&path)?).file_name(name));
    for setting in arguments {
        let (name, value) = setting
            .split_once('=')
            .ok_or_else(|| format!("{setting:?} is not NAME=VALUE"))?;
        form = form.text(name.to_owned(), value.to_owned());
    }

    let client = Client::new();
    let accepted = client
        .post(format!("{server}/jobs"))
        .multipart(form)
        .send()
        .await?;
    let location = accepted
        .headers()
        .get(LOCATION)
        .and_then(|value| value.to_str().ok())
        .map(|path| format!("{server}{path}"));
    checked(accepted).await?;
    let job_url = location.ok_or("the server sent no Location")?;
    println!("job       {job_url}");

    let job = finished(&client, &job_url).await?;
    match job["state"].as_str() {
        Some("succeeded") => print_result(&job["result"]),
        Some("failed") => {
            return Err(format!("the job failed: {}", job["problem"]["detail"]).into());
        }
        _ => return Err(format!("the job was {}", job["state"]).into()),
    }
    Ok(())
}

/// Polls until the job has ended, as often as the server asks for, showing its progress.
async fn finished(client: &Client, job_url: &str) -> Result<Value, Box<dyn Error>> {
    loop {
        let response = client.get(job_url).send().await?;
        let wait = response
            .headers()
            .get(RETRY_AFTER)
            .and_then(|value| value.to_str().ok()?.parse().ok())
            .unwrap_or(1);
        let job = checked(response).await?;
        if !matches!(job["state"].as_str(), Some("queued" | "running")) {
            return Ok(job);
        }
        match &job["progress"] {
            Value::Null => println!("{}", job["state"].as_str().unwrap_or_default()),
            progress => println!(
                "{:<9} generation {} of {}, {} evaluations, best quality {}",
                progress["phase"].as_str().unwrap_or_default(),
                progress["generation"],
                progress["generations"],
                progress["evaluations"],
                progress["best_quality"],
            ),
        }
        tokio::time::sleep(Duration::from_secs(wait)).await;
    }
}

/// The JSON of a good answer, or the problem of a bad one as the error.
async fn checked(response: Response) -> Result<Value, Box<dyn Error>> {
    let status = response.status();
    let body: Value = response.json().await?;
    if status.is_success() {
        return Ok(body);
    }
    let mut message = format!("{status}: {}", body["detail"].as_str().unwrap_or_default());
    for error in body["errors"].as_array().into_iter().flatten() {
        message += &format!("\n  {}: {}", error["pointer"], error["detail"]);
    }
    Err(message.into())
}

fn print_result(result: &Value) {
    if result["force_closure"] != true {
        let detail = result["explanation"]["detail"].as_str();
        println!("no force closure: {}", detail.unwrap_or_default());
        return;
    }
    println!(
        "quality   {:.5} (first grasp {:.5}), {} evaluations in {:.2} s, seed {}",
        number(&result["quality"]),
        number(&result["initial"]["quality"]),
        result["evaluations"],
        number(&result["elapsed_s"]),
        result["seed"],
    );
    println!(
        "weakest   {}",
        result["weakest_wrench"]["description"]
            .as_str()
            .unwrap_or_default()
    );
    println!(
        "contact   {:^30}  {:^30}",
        "position", "normal (into the body)"
    );
    for (i, contact) in result["contacts"]
        .as_array()
        .into_iter()
        .flatten()
        .enumerate()
    {
        println!(
            "{:>7}   {}  {}",
            i + 1,
            vector(&contact["position"]),
            vector(&contact["normal"])
        );
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn vector(value: &Value) -> String {
    let parts = value.as_array().into_iter().flatten();
    parts
        .map(|part| format!("{:>10.4}", number(part)))
        .collect()
}
