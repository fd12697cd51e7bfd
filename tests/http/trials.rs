//! Jobs that repeat a run with other seeds, and jobs that return several grasps.

use serde_json::{Value, json};

use crate::common::{Server, server, small_box};

const SEED: u64 = 11;

/// A request that is planned in no time, with these members besides.
fn quick(more: Value) -> Value {
    let mut request = json!({"population": 4, "generations": 3, "seed": SEED});
    for (name, value) in more.as_object().unwrap() {
        request[name] = value.clone();
    }
    request
}

async fn planned(server: &Server, mesh: &str, request: Value) -> Value {
    let job = server.job(mesh, request).await;
    server.wait_for(&job, &["succeeded"]).await;
    server.json(&format!("/jobs/{job}/result")).await
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// Asserts that `statistics` has the mean, standard deviation, least and greatest of `values`.
fn assert_statistics(statistics: &Value, values: &[f64]) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|x| x * x - mean * mean).sum::<f64>() / (count - 1.0);
    let greatest = values.iter().copied().fold(f64::MIN, f64::max);
    for (name, expected) in [
        ("mean", mean),
        ("sd", variance.max(0.0).sqrt()),
        ("min", values.iter().copied().fold(f64::MAX, f64::min)),
        ("max", greatest),
    ] {
        let found = number(&statistics[name]);
        // The sum of squares above loses half of the digits where all numbers are alike.
        let error = (found - expected).abs();
        assert!(
            error <= 1e-7 * greatest,
            "{name}: {found} is not {expected}"
        );
    }
}

/// Without the times, which alone may differ.
fn timeless(mut result: Value) -> String {
    result["elapsed_s"].take();
    result["trials"]["elapsed_s"].take();
    for list in ["/history", "/trials/runs"] {
        let entries = result.pointer_mut(list).and_then(Value::as_array_mut);
        for entry in entries.into_iter().flatten() {
            entry["elapsed_s"].take();
        }
    }
    result.to_string()
}

#[tokio::test(flavor = "multi_thread")]
async fn trials_are_the_runs_of_the_seeds_that_follow() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let result = planned(&server, &mesh, quick(json!({"trials": 4}))).await;
    let mut singles = Vec::new();
    for seed in SEED..SEED + 4 {
        singles.push(planned(&server, &mesh, quick(json!({"seed": seed}))).await);
    }
    let trials = &result["trials"];
    assert_eq!(
        (&trials["count"], &trials["force_closures"]),
        (&json!(4), &json!(4))
    );
    let runs = trials["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 4);
    for (run, single) in runs.iter().zip(&singles) {
        assert_eq!(run["seed"], single["seed"]);
        assert_eq!(run["initial"], single["initial"]["quality"]);
        assert_eq!(run["last"], single["quality"]);
        assert_eq!(run["evaluations"], single["evaluations"]);
        assert_eq!(run["stopped_because"], single["stopped_because"]);
    }
    let of = |member: &dyn Fn(&Value) -> f64| -> Vec<f64> { singles.iter().map(member).collect() };
    let (first, last) = (
        |single: &Value| number(&single["initial"]["quality"]),
        |single: &Value| number(&single["quality"]),
    );
    assert_statistics(&trials["initial"], &of(&first));
    assert_statistics(&trials["last"], &of(&last));
    assert_statistics(&trials["ratio"], &of(&|s| last(s) / first(s)));
    let evaluations = of(&|single| number(&single["evaluations"]));
    assert_statistics(&trials["evaluations"], &evaluations);
    assert_eq!(
        number(&result["evaluations"]),
        evaluations.iter().sum::<f64>()
    );
    let times: Vec<f64> = runs.iter().map(|run| number(&run["elapsed_s"])).collect();
    assert_statistics(&trials["elapsed_s"], &times);
    assert!(times.iter().all(|time| *time > 0.0));
    assert!(number(&result["elapsed_s"]) >= times.iter().sum::<f64>());

    let best = singles
        .iter()
        .reduce(|a, b| if last(b) > last(a) { b } else { a });
    for member in ["seed", "quality", "contacts", "initial", "weakest_wrench"] {
        assert_eq!(result[member], best.unwrap()[member], "{member}");
    }
    let again = planned(&server, &mesh, quick(json!({"trials": 4}))).await;
    assert_eq!(timeless(again), timeless(result));
}

#[tokio::test(flavor = "multi_thread")]
async fn trials_without_a_grasp_have_no_statistics_of_it() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let result = planned(&server, &mesh, quick(json!({"trials": 3, "contacts": 2}))).await;
    let trials = &result["trials"];
    assert_eq!(
        (&trials["count"], &trials["force_closures"]),
        (&json!(3), &json!(0))
    );
    for member in ["initial", "last", "ratio"] {
        assert_eq!(trials[member], Value::Null, "{member}");
    }
    assert_statistics(&trials["evaluations"], &[0.0; 3]);
    assert_eq!(result["explanation"]["reason"], "too_few_contacts");
}

fn positions(grasp: &Value) -> Vec<[f64; 3]> {
    let contacts = grasp["contacts"].as_array().unwrap().iter();
    contacts
        .map(|contact| serde_json::from_value(contact["position"].clone()).unwrap())
        .collect()
}

/// Hausdorff distance.
fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let distance = |p: &[f64; 3], q: &[f64; 3]| {
        let squares: f64 = p.iter().zip(q).map(|(x, y)| (x - y).powi(2)).sum();
        squares.sqrt()
    };
    let to = |p: &[f64; 3], all: &[[f64; 3]]| {
        let distances = all.iter().map(|q| distance(p, q));
        distances.fold(f64::MAX, f64::min)
    };
    let there = a.iter().map(|p| to(p, b)).fold(0.0, f64::max);
    b.iter().map(|p| to(p, a)).fold(there, f64::max)
}

/// Asserts that grasps are distinct and sorted and that the first is that of the result; gives how many.
fn assert_distinct(result: &Value) -> usize {
    let top = result["top"].as_array().unwrap();
    assert_eq!(top[0]["contacts"].as_array().unwrap().len(), 4);
    assert_eq!(top[0]["quality"], result["quality"]);
    assert_eq!(positions(&top[0]), positions(result));
    // Half of the diagonal of the box, of which a twentieth is the least distance.
    let radius = (0.25_f64 + 1.0 + 2.25).sqrt();
    for (i, grasp) in top.iter().enumerate() {
        let far = apart(&positions(grasp), &positions(&top[0]));
        assert!((number(&grasp["distance_to_best"]) - far).abs() < 1e-12);
        for other in &top[..i] {
            assert!(number(&grasp["quality"]) <= number(&other["quality"]));
            assert!(apart(&positions(grasp), &positions(other)) >= 0.05 * radius - 1e-12);
        }
    }
    top.len()
}

#[tokio::test(flavor = "multi_thread")]
async fn the_top_grasps_are_distinct_and_sorted() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    for settings in [
        json!({"top": 5, "population": 8}),
        json!({"top": 3, "method": "modified_ga", "population": 40}),
        json!({"top": 4, "method": "random", "population": 60, "wrench_space": "linf"}),
    ] {
        let result = planned(&server, &mesh, quick(settings.clone())).await;
        assert_eq!(json!(assert_distinct(&result)), settings["top"]);
        let again = planned(&server, &mesh, quick(settings)).await;
        assert_eq!(timeless(again), timeless(result));
    }
    let one = planned(&server, &mesh, quick(json!({}))).await;
    assert!(one.get("top").is_none_or(Value::is_null));
}

#[tokio::test(flavor = "multi_thread")]
async fn there_are_fewer_top_grasps_when_there_are_no_more() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    // One place amid each face: 15 grasps of four contacts.
    let places: Vec<usize> = (0..6).map(|face| 32 * face + 10).collect();
    let result = planned(
        &server,
        &mesh,
        quick(json!({
            "top": 20, "method": "random", "population": 200, "friction": 1,
            "constraints": {"include": [{"triangles": places}]}
        })),
    )
    .await;
    assert_eq!(result["candidates"], 6);
    let count = assert_distinct(&result);
    assert!((2..=15).contains(&count), "{count}");
}
