//! `graspd reproduce` at its smallest.

use std::process::Command;

fn graspd(arguments: &[&str]) -> std::process::Output {
    let output = Command::new(testkit::process::binary())
        .args(arguments)
        .output();
    output.expect("the binary runs")
}

#[test]
fn its_table_is_what_single_plans_find() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    let output = graspd(&[
        "reproduce",
        "--runs",
        "2",
        "--seed",
        "5",
        "--only",
        "box-7",
        "--no-grids",
        "--output",
        path,
    ]);
    assert!(output.status.success(), "{output:?}");
    let table = std::fs::read_to_string(folder.path().join("table.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    assert_eq!(rows.len(), 1 + 4 * 2);
    let last = |method: &str, seed: &str| -> f64 {
        let row = rows.iter().find(|row| row[2] == method && row[3] == seed);
        row.unwrap()[5].parse().unwrap()
    };
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/meshes/box.stl");
    for seed in ["5", "6"] {
        let plan = graspd(&[
            "plan",
            mesh,
            "--json",
            "--friction",
            "0",
            "--polish",
            "false",
            "--initial",
            "strict",
            "--generations",
            "100000",
            "--evaluation-limit",
            "12400",
            "--seed",
            seed,
            "--threads",
            "1",
        ]);
        let plan: serde_json::Value = serde_json::from_slice(&plan.stdout).unwrap();
        assert_eq!(plan["quality"].as_f64(), Some(last("memetic", seed)));
        assert!(last("memetic", seed) > last("modified_ga", seed));
    }
    let text = std::fs::read_to_string(folder.path().join("reproduction.md")).unwrap();
    assert!(text.contains("| modified_ga |") && text.contains("| memetic |"));
    let svg = std::fs::read_to_string(folder.path().join("box-7-history.svg")).unwrap();
    assert_eq!(svg.matches("<polyline").count(), 4);
    assert!(svg.ends_with("</svg>\n"));
}

#[test]
fn a_folder_without_the_mesh_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    let output = graspd(&[
        "reproduce",
        "--only",
        "duck-4",
        "--meshes",
        path,
        "--output",
        path,
    ]);
    assert_eq!(output.status.code(), Some(1));
    let fault = String::from_utf8(output.stderr).unwrap();
    assert!(
        fault.contains("no file in") && fault.contains("duck"),
        "{fault}"
    );
}
