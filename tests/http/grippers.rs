//! Grasps of two contacts as poses of a gripper.

use std::sync::Arc;

use graspd::jobs::Runner;
use serde_json::value::to_raw_value;
use serde_json::{Value, json};

use crate::common::{problem, server, small_box, start};
use crate::exports::{numbers, pinch, planned};

/// Where the jaws touch, by a pose alone: the turned x axis, half of the opening each way.
fn touched(position: &[f64], [w, x, y, z]: [f64; 4], opening: f64) -> [Vec<f64>; 2] {
    let axis = [
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y + w * z),
        2.0 * (x * z - w * y),
    ];
    let end = |side: f64| {
        let ends = position.iter().zip(axis);
        ends.map(|(middle, x)| middle + side * x * opening / 2.0)
            .collect()
    };
    [end(-1.0), end(1.0)]
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pinch_is_the_pose_of_a_gripper() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    for (units, query, meters) in [
        (Some("cm"), "", 0.01),
        (Some("cm"), "?units=cm", 0.01),
        (None, "?units=in", 0.0254),
        (None, "?units=m&grasp=initial", 1.0),
    ] {
        let mut settings = pinch();
        match units {
            Some(units) => settings["units"] = units.into(),
            None => drop(settings.as_object_mut().unwrap().remove("units")),
        }
        let job = planned(&server, &mesh, settings).await;
        let result = server.json(&format!("/jobs/{job}/result")).await;
        assert_eq!(result["force_closure"], true, "{result}");
        let grasp = match query.contains("initial") {
            true => &result["initial"],
            false => &result,
        };
        let contacts = [0, 1].map(|n| numbers(&grasp["contacts"][n]["position"]));
        let same = |found: [Vec<f64>; 2]| {
            for (found, wanted) in found.iter().zip(&contacts) {
                for (found, wanted) in found.iter().zip(wanted) {
                    assert!((found - wanted * meters).abs() < 1e-12, "{query}");
                }
            }
        };

        let path = format!("/jobs/{job}/grasp.moveit.json{query}");
        let message: Value = serde_json::from_slice(&server.bytes(&path).await).expect("JSON");
        let pose = &message["grasp_pose"]["pose"];
        let position = ["x", "y", "z"].map(|axis| pose["position"][axis].as_f64().unwrap());
        let turn = ["w", "x", "y", "z"].map(|part| pose["orientation"][part].as_f64().unwrap());
        let opening = message["grasp_posture"]["points"][0]["positions"][0].as_f64();
        same(touched(&position, turn, opening.unwrap()));
        assert_eq!(message["grasp_quality"], grasp["quality"]);

        let text = server
            .text(&format!("/jobs/{job}/grasp.isaac.yaml{query}"))
            .await;
        let line = |key: &str| -> Vec<f64> {
            let line = text.lines().find_map(|line| line.trim().strip_prefix(key));
            let words = line.unwrap_or_else(|| panic!("no {key} in {text}"));
            words
                .split(&[' ', ',', '[', ']', '{', '}'][..])
                .filter_map(|word| word.parse().ok())
                .collect()
        };
        let turn = line("orientation:").try_into().expect("a quaternion");
        same(touched(&line("position:"), turn, line("opening:")[0]));
        assert_eq!(line("confidence:"), [grasp["quality"].as_f64().unwrap()]);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn other_grasps_and_unknown_units_are_refused_with_the_reason() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let hard = json!({"contacts": 2, "units": "cm"});
    for (settings, reason) in [
        (json!({"units": "cm"}), "4 contacts"),
        (json!({"contacts": 2, "contact_model": "soft"}), "?units="),
        // Two of these hold no body; the result says what would.
        (hard, "3 or more"),
    ] {
        let job = planned(&server, &mesh, settings).await;
        for name in ["grasp.isaac.yaml", "grasp.moveit.json"] {
            let refused = server.answer(&format!("/jobs/{job}/{name}")).await;
            let problem = problem(refused, 409).await;
            let detail = problem["detail"].as_str().unwrap();
            assert!(detail.contains(reason), "{name}: {detail}");
        }
    }
    // Found by another planner: friction of 0.5 does not hold 45 degrees.
    let contact = |position: [f64; 3], normal: [f64; 3]| json!({"position": position, "normal": normal, "approach": normal.map(|x| -x)});
    let slope = 0.5_f64.sqrt();
    let skew = json!({
        "force_closure": false, "frame": "mesh", "torque_scale": {"kind": "none", "value": 1.0},
        "contacts": [contact([-0.5, 0.0, 0.0], [1.0, 0.0, 0.0]), contact([0.5, 0.0, 0.0], [-slope, slope, 0.0])],
        "center_of_mass": [0.0, 0.0, 0.0], "contact_model": "soft", "friction": 0.5, "edge_norm": "unit_edge",
        "units": "m", "candidates": 2, "method": "random", "seed": 0, "stopped_because": "generation_limit",
        "evaluations": 1, "history": [], "elapsed_s": 0.0, "version": "0",
    });
    let skew = to_raw_value(&skew).unwrap();
    let runner: Arc<Runner> = Arc::new(move |_, _, _, _| Ok(skew.clone()));
    let folder = tempfile::tempdir().expect("a folder");
    let server = start(folder, &[], |_| {}, Some(runner)).await;
    let mesh = server.mesh(small_box()).await;
    let job = planned(&server, &mesh, json!({})).await;
    for name in ["grasp.isaac.yaml", "grasp.moveit.json"] {
        let refused = server.answer(&format!("/jobs/{job}/{name}")).await;
        let problem = problem(refused, 409).await;
        let detail = problem["detail"].as_str().unwrap();
        assert!(
            detail.contains("contact 2 is 45.0 degrees off"),
            "{name}: {detail}"
        );
    }
}
