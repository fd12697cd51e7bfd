//! Requests for analyses.

use nalgebra::Vector3;
use serde_json::json;

use crate::wire::{EvaluationRequest, PlanRequest};
use graspd_core::analysis::AnalysisSettings;
use graspd_core::effort::ExternalWrench;
use graspd_core::independent::Fraction;
use graspd_core::robustness::Scatter;

#[test]
fn defaults_are_filled_in() {
    let asked = json!({
        "robustness": {"sigma": 0.25}, "independent_regions": {},
        "task_wrenches": [[0, 0, 1, 0, 0, 0]], "gravity": [0, 0, -9.81]
    });
    let request = PlanRequest::from_json(&asked, 1).unwrap();
    let expected = AnalysisSettings {
        robustness: Some(Scatter {
            sigma: 0.25,
            samples: 200,
            seed: 0,
        }),
        regions: Fraction::new(0.5),
        tasks: vec![ExternalWrench {
            force: Vector3::z(),
            torque: Vector3::zeros(),
        }],
        gravity: Some(Vector3::new(0.0, 0.0, -9.81)),
    };
    assert_eq!(request.analyses, expected);
    let mut evaluation = asked;
    evaluation["grasps"] = json!([[{"triangle": 1}]]);
    let evaluation = EvaluationRequest::from_json(&evaluation).unwrap();
    assert_eq!(evaluation.analyses, expected);
    let nothing = PlanRequest::from_json(&json!({}), 1).unwrap();
    assert_eq!(nothing.analyses, AnalysisSettings::default());
}

#[test]
fn faults_are_told_with_their_place() {
    for (asked, pointer) in [
        (json!({"robustness": 0.5}), "/robustness"),
        (json!({"robustness": null}), "/robustness"),
        (json!({"robustness": {}}), "/robustness/sigma"),
        (json!({"robustness": {"sigma": 0}}), "/robustness/sigma"),
        (
            json!({"robustness": {"sigma": 1, "samples": 0}}),
            "/robustness/samples",
        ),
        (
            json!({"robustness": {"sigma": 1, "samples": 10_001}}),
            "/robustness/samples",
        ),
        (
            json!({"robustness": {"sigma": 1, "seed": -1}}),
            "/robustness/seed",
        ),
        (
            json!({"robustness": {"sigma": 1, "n/m": 1}}),
            "/robustness/n~1m",
        ),
        (json!({"independent_regions": true}), "/independent_regions"),
        (
            json!({"independent_regions": {"fraction": 0}}),
            "/independent_regions/fraction",
        ),
        (
            json!({"independent_regions": {"fraction": 1.1}}),
            "/independent_regions/fraction",
        ),
        (json!({"task_wrenches": []}), "/task_wrenches"),
        (
            json!({"task_wrenches": vec![[1; 6]; 257]}),
            "/task_wrenches",
        ),
        (
            json!({"task_wrenches": [[1, 0, 0, 0, 0, 0], [1, 2, 3]]}),
            "/task_wrenches/1",
        ),
        (
            json!({"task_wrenches": [[0, 0, 0, 0, 0, 0]]}),
            "/task_wrenches/0",
        ),
        (
            json!({"task_wrenches": [[0, 0, 1e13, 0, 0, 0]]}),
            "/task_wrenches/0",
        ),
        (json!({"gravity": [0, 0, 0]}), "/gravity"),
        (json!({"gravity": -9.81}), "/gravity"),
        (json!({"gravity": [0, 0, "down"]}), "/gravity"),
    ] {
        let faults = PlanRequest::from_json(&asked, 1).expect_err("refused");
        let pointers: Vec<_> = faults.iter().map(|fault| &fault.pointer).collect();
        assert_eq!(pointers, [pointer], "{asked}");
    }
}

#[test]
fn a_form_means_what_the_same_json_means() {
    let form = [
        (
            "robustness",
            r#"{"sigma": 0.25, "seed": 18446744073709551615}"#,
        ),
        ("independent_regions", "{}"),
        ("task_wrenches", "[[0, 0, 1, 0, 0, 0]]"),
        ("gravity", "0,0,-1"),
    ];
    let json = json!({
        "robustness": {"sigma": 0.25, "seed": u64::MAX}, "independent_regions": {},
        "task_wrenches": [[0, 0, 1, 0, 0, 0]], "gravity": [0, 0, -1]
    });
    let owned = form.map(|(name, text)| (name.to_owned(), text.to_owned()));
    assert_eq!(
        PlanRequest::from_form(owned, 1),
        PlanRequest::from_json(&json, 1)
    );
    for text in ["sigma", "{\"sigma\": 1, \"sigma\": 2}", "{\"sigma\": 1", ""] {
        let form = [("robustness".to_owned(), text.to_owned())];
        let faults = PlanRequest::from_form(form, 1).unwrap_err();
        assert_eq!(faults[0].pointer, "/robustness");
    }
}
