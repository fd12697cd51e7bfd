//! Constraints of a planning request: over HTTP, and the same from the command line.

use std::path::Path;
use std::process::{Command, Output};

use reqwest::StatusCode;
use reqwest::multipart::Part;
use serde_json::{Value, json};

use crate::common::{file, pointers, problem, server, small_box};

/// A request that is planned in no time.
fn quick(constraints: Value) -> Value {
    json!({
        "population": 20, "generations": 3, "seed": 7, "candidates": "triangles",
        "constraints": constraints
    })
}

fn both_ends() -> Value {
    json!({
        "exclude": [{"box": {"min": [-1, -2, -0.7], "max": [1, 2, 0.7]}}],
        "max_contact_distance": 3.4,
        "fixed_contacts": [{"point": [0.25, 0.5, 5]}]
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn a_constrained_job_is_the_same_in_every_form_of_request() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let mut ids = vec![server.job(&mesh, quick(both_ends())).await];
    let fields = file(small_box())
        .text("population", "20")
        .text("generations", "3")
        .text("seed", "7")
        .text("candidates", r#"{"kind": "triangles"}"#)
        .text("constraints", both_ends().to_string());
    let part = file(small_box()).part("request", Part::text(quick(both_ends()).to_string()));
    for form in [fields, part] {
        let answer = server.post("/jobs").multipart(form).send().await.unwrap();
        assert_eq!(answer.status(), StatusCode::ACCEPTED);
        let job: Value = answer.json().await.unwrap();
        ids.push(job["id"].as_str().unwrap().to_owned());
    }
    let mut first = None;
    for id in ids {
        let done = server.wait_for(&id, &["succeeded"]).await;
        assert_eq!(done["request"]["constraints"]["max_contact_distance"], 3.4);
        let mut result = done["result"].clone();
        assert_eq!(result["force_closure"], true, "{result}");
        let fixed = &result["contacts"][0];
        assert_eq!(
            (&fixed["fixed"], &fixed["position"]),
            (&json!(true), &json!([0.25, 0.5, 1.5]))
        );
        assert!(result["contacts"][1].get("fixed").is_none());
        for contact in result["contacts"].as_array().unwrap() {
            assert!(contact["position"][2].as_f64().unwrap().abs() > 0.7);
        }
        let rules: Vec<&Value> = result["constraints"]
            .as_array()
            .unwrap()
            .iter()
            .map(|rule| &rule["rule"])
            .collect();
        assert_eq!(
            rules,
            ["exclude[0]", "fixed_contacts", "max_contact_distance"]
        );
        result["elapsed_s"].take();
        result["history"].take();
        assert_eq!(*first.get_or_insert(result.clone()), result);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn bad_constraints_are_named() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    for (constraints, pointer) in [
        (json!("x"), ""),
        (json!(null), ""),
        (json!({"include": 1}), "/include"),
        (
            json!({"include": [{"box": {"min": [1, 0, 0], "max": [0, 1, 1]}}]}),
            "/include/0/box/min",
        ),
        (json!({"include": [{"box": {}}]}), "/include/0/box/min"),
        (
            json!({"exclude": [{"half_space": {"point": [0, 0, 0], "normal": [0, 0, 0]}}]}),
            "/exclude/0/half_space/normal",
        ),
        (
            json!({"min_contact_distance": 2, "max_contact_distance": 1}),
            "/min_contact_distance",
        ),
        (json!({"max_normal_angle": 10}), "/max_normal_angle"),
        (json!({"no_such_rule": 1}), "/no_such_rule"),
        (
            json!({"fixed_contacts": [{"triangle": 0}, {"triangle": 1}, {"triangle": 2}, {"triangle": 3}]}),
            "/fixed_contacts",
        ),
    ] {
        let body = json!({"mesh_id": mesh, "constraints": constraints});
        let refused = problem(server.post("/jobs").json(&body).send().await.unwrap(), 422).await;
        assert_eq!(pointers(&refused)[0], format!("/constraints{pointer}"));
        if constraints.is_object() {
            let form = file(small_box()).text("constraints", constraints.to_string());
            let same = server.post("/jobs").multipart(form).send().await.unwrap();
            assert_eq!(problem(same, 422).await, refused);
        }
    }
    let form = file(small_box()).text("constraints", "{\"include\": [}");
    let refused = server.post("/jobs").multipart(form).send().await.unwrap();
    assert_eq!(pointers(&problem(refused, 422).await), ["/constraints"]);
    assert_eq!(server.json("/jobs").await["jobs"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn constraints_without_a_grasp_succeed_and_a_triangle_that_is_not_there_fails() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let none = quick(json!({"include": [{"triangles": [0, 1, 2]}]}));
    let done = server
        .wait_for(&server.job(&mesh, none).await, &["succeeded"])
        .await;
    let result = &done["result"];
    assert_eq!(result["explanation"]["reason"], "constraints", "{result}");
    assert_eq!(result["stopped_because"], "infeasible");
    assert_eq!(result["candidates"], 3);
    assert_eq!(
        result["constraints"],
        json!([{"rule": "include", "removed": 189}])
    );
    let unknown = quick(json!({"fixed_contacts": [{"triangle": 192}]}));
    let failed = server
        .wait_for(&server.job(&mesh, unknown).await, &["failed"])
        .await;
    assert!(
        failed
            .to_string()
            .contains("/constraints/fixed_contacts/0/triangle")
    );
}

/// `graspd plan` on the small box with these constraints.
fn command(mesh: &Path, constraints: &str) -> Output {
    Command::new(testkit::process::binary())
        .arg("plan")
        .arg(mesh)
        .args([
            "--json",
            "--seed",
            "7",
            "--population",
            "20",
            "--generations",
            "3",
        ])
        .args(["--constraints", constraints])
        .output()
        .unwrap()
}

#[test]
fn the_command_reads_constraints_from_a_file_or_the_flag() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("box.stl");
    std::fs::write(&mesh, small_box()).unwrap();
    let path = folder.path().join("constraints.json");
    std::fs::write(&path, both_ends().to_string()).unwrap();
    let planned = |constraints: &str| {
        let output = command(&mesh, constraints);
        assert!(output.status.success(), "{output:?}");
        let mut result: Value = serde_json::from_slice(&output.stdout).unwrap();
        result["elapsed_s"].take();
        result["history"].take();
        result
    };
    let inline = planned(&both_ends().to_string());
    assert_eq!(inline["contacts"][0]["fixed"], true);
    assert_eq!(planned(path.to_str().unwrap()), inline);
    for (constraints, expected) in [
        ("{\"include\": 1}", "--constraints /include: must be a list"),
        (
            "no-such-file.json",
            "--constraints: cannot read no-such-file.json",
        ),
        ("{", "--constraints: the JSON cannot be read"),
    ] {
        let output = command(&mesh, constraints);
        assert_eq!(output.status.code(), Some(2));
        let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(complaint.contains(expected), "{complaint}");
    }
}
