//! The five cases of the paper (Rakesh et al. 2016, §4) at its population and generations, on the
//! example meshes: over HTTP, and the same from the command line.

use std::process::Command;

use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use super::common::{Server, server};

/// Mesh, settings.
fn cases() -> [(&'static str, Value); 5] {
    let frictionless = |population: u32, generations: u32| {
        json!({"contact_model": "frictionless", "contacts": 7,
               "method": "modified_ga", "population": population, "generations": generations, "seed": 1})
    };
    let hard = json!({"contacts": 4, "friction": 0.2, "cone_edges": 8,
                      "method": "modified_ga", "population": 200, "generations": 20, "seed": 1});
    [
        ("box.stl", frictionless(400, 30)),
        ("knight.stl", frictionless(200, 20)),
        ("knight.stl", hard.clone()),
        ("rabbit.ply", hard.clone()),
        ("duck.obj", hard),
    ]
}

fn path(name: &str) -> String {
    format!("{}/examples/meshes/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The result as JSON text in the order of the server, without its times.
fn timeless(text: &str) -> String {
    let time = |part: &str| part.find([',', '}']).map_or(0, |end| end);
    let mut parts = text.split("\"elapsed_s\":");
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        kept += &part[time(part)..];
    }
    kept.trim_end().to_owned()
}

async fn over_http(server: &Server, name: &str, settings: &Value) -> String {
    let bytes = std::fs::read(path(name)).unwrap();
    let form = Form::new().part("mesh", Part::bytes(bytes).file_name(name.to_owned()));
    let upload = server.post("/meshes").multipart(form).send().await.unwrap();
    let mesh: Value = upload.json().await.unwrap();
    let job = server
        .job(mesh["id"].as_str().unwrap(), settings.clone())
        .await;
    server.wait_for(&job, &["succeeded"]).await;
    let answer = server.get(&format!("/jobs/{job}/result")).send().await;
    answer.unwrap().text().await.unwrap()
}

/// On two threads, whatever the server uses.
fn from_the_command_line(name: &str, settings: &Value) -> String {
    let mut command = Command::new(testkit::process::binary());
    command.args(["plan", &path(name), "--json", "--threads", "2"]);
    for (name, value) in settings.as_object().unwrap() {
        let value = value
            .as_str()
            .map_or_else(|| value.to_string(), str::to_owned);
        command.args([format!("--{}", name.replace('_', "-")), value]);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn its_five_cases_end_in_better_grasps_and_the_command_line_agrees() {
    let server = server().await;
    let mut gains = Vec::new();
    for (name, settings) in cases() {
        let text = over_http(&server, name, &settings).await;
        assert_eq!(
            timeless(&text),
            timeless(&from_the_command_line(name, &settings)),
            "{name}"
        );
        let result: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(result["force_closure"], true, "{name}");
        assert_eq!(
            result["contacts"].as_array().unwrap().len(),
            settings["contacts"]
        );
        assert_eq!(result["stopped_because"], "generation_limit");

        let history = result["history"].as_array().unwrap();
        let generations = settings["generations"].as_u64().unwrap();
        assert_eq!(history.len() as u64, generations + 1);
        let best: Vec<f64> = history
            .iter()
            .map(|g| g["best"].as_f64().unwrap())
            .collect();
        assert!(best.windows(2).all(|pair| pair[0] <= pair[1]));
        let initial = result["initial"]["quality"].as_f64().unwrap();
        let last = result["quality"].as_f64().unwrap();
        assert!(best[0] >= initial && last == best[best.len() - 1]);
        gains.push(last / initial);
        let population = settings["population"].as_u64().unwrap();
        let bred = population + generations * (population - 1);
        assert!(result["evaluations"].as_u64().unwrap() > bred);
    }
    // One run may start from a grasp that is good by chance; the five together do not.
    let mean = gains.iter().map(|gain| gain.ln()).sum::<f64>() / gains.len() as f64;
    assert!(mean > 1.5f64.ln(), "{gains:?}");
}
