//! Requests that are taken and requests that are refused.

use serde_json::{Value, json};
use utoipa::PartialSchema;

use super::SETTINGS;
use crate::wire::{FieldError, PlanRequest, PlanRequestInput};
use graspd_core::plan::{ContactFields, ContactKind};

fn read(value: Value) -> Result<PlanRequest, Vec<FieldError>> {
    PlanRequest::from_json(&value, 1)
}

fn pointers(value: Value) -> Vec<String> {
    read(value)
        .expect_err("refused")
        .into_iter()
        .map(|error| error.pointer)
        .collect()
}

#[test]
fn defaults_follow_the_contact_model() {
    let contact = |request: &PlanRequest| ContactFields::from(request.quality.wrench.contact);
    let hard = read(json!({})).unwrap();
    let fields = contact(&hard);
    assert_eq!(
        (hard.contacts, fields.friction, fields.cone_edges, hard.seed),
        (4, Some(0.5), Some(8), 1)
    );
    for frictionless in [
        json!({"contact_model": "frictionless"}),
        json!({"friction": 0}),
    ] {
        let request = read(frictionless).unwrap();
        let fields = contact(&request);
        assert_eq!(fields.contact_model, ContactKind::Frictionless);
        assert_eq!(
            (request.contacts, fields.friction, fields.cone_edges),
            (7, None, None)
        );
    }
}

#[test]
fn the_effective_request_is_accepted_again() {
    for start in [
        json!({"torque_scale": 2.5, "units": "mm", "center_of_mass": [0, 1.5, -2], "seed": u64::MAX}),
        json!({"robustness": {"sigma": 1}, "independent_regions": {}, "task_wrenches": [[0, 0, 1, 0, 0, 0]], "gravity": [0, 0, -1]}),
        json!({"friction": 0, "torque_scale": "none", "label": "x", "time_limit_s": 1, "method": "modified_ga"}),
    ] {
        let request = read(start).unwrap();
        let written = serde_json::to_value(&request).unwrap();
        assert_eq!(read(written.clone()).unwrap(), request);
        assert_eq!(
            serde_json::from_value::<PlanRequest>(written).unwrap(),
            request
        );
    }
}

#[test]
fn the_table_of_fields_and_the_type_agree() {
    let schema = serde_json::to_value(PlanRequestInput::schema()).unwrap();
    let mut described: Vec<_> = schema["properties"]
        .as_object()
        .unwrap()
        .keys()
        .cloned()
        .collect();
    let mut listed: Vec<_> = SETTINGS
        .iter()
        .map(|setting| setting.name.to_owned())
        .collect();
    described.sort();
    listed.sort();
    assert_eq!(described, listed);
}

#[test]
fn every_fault_is_reported_with_its_pointer() {
    let faults = json!({
        "contacts": 65, "friction": -1, "cone_edges": 2, "torsional_friction": 0, "wrench_space": "l2", "edge_norm": "x", "torque_scale": 0,
        "center_of_mass": [0, "a", 1e13], "units": "furlong", "constraints": 7, "method": "magic",
        "population": 0, "generations": 1_000_000_000, "crossover_probability": 1.1,
        "mutation_probability": null, "elitism": -1, "initial": 3, "time_limit_s": 0,
        "evaluation_limit": 0.5, "target_quality": "high", "seed": -1,
        "robustness": 1, "independent_regions": [], "task_wrenches": {}, "gravity": [0, 0],
        "label": "a\u{202e}b", "a/b~c": 1
    });
    let mut found = pointers(faults.clone());
    let mut expected: Vec<_> = faults
        .as_object()
        .unwrap()
        .keys()
        .filter(|name| !name.contains('/') && *name != "center_of_mass")
        .map(|name| format!("/{name}"))
        .chain([
            "/center_of_mass/1".into(),
            "/center_of_mass/2".into(),
            "/a~1b~0c".into(),
        ])
        .collect();
    found.sort();
    expected.sort();
    assert_eq!(found, expected);
}

#[test]
fn fields_that_contradict_each_other_are_refused() {
    assert_eq!(
        pointers(json!({"contact_model": "frictionless", "friction": 0.5})),
        ["/friction"]
    );
    assert_eq!(
        pointers(json!({"friction": 0, "cone_edges": 8})),
        ["/cone_edges"]
    );
    assert_eq!(
        pointers(json!({"population": 100_000, "generations": 100_000})),
        ["/generations"]
    );
    assert_eq!(
        pointers(json!({"population": 2, "elitism": 2})),
        ["/elitism"]
    );
    assert_eq!(pointers(json!([])), [""]);
}

#[test]
fn a_form_means_what_the_same_json_means() {
    let form = [
        ("contacts", "5"),
        ("friction", "0.25"),
        ("torque_scale", "2e0"),
        ("label", "7"),
        ("center_of_mass", "1, 2,-3.5"),
        ("seed", "18446744073709551615"),
        ("units", "mm"),
    ];
    let json = json!({
        "contacts": 5, "friction": 0.25, "torque_scale": 2.0, "label": "7",
        "center_of_mass": [1, 2, -3.5], "seed": u64::MAX, "units": "mm"
    });
    let owned = form.map(|(name, text)| (name.to_owned(), text.to_owned()));
    assert_eq!(PlanRequest::from_form(owned, 1), read(json));
}

#[test]
fn a_form_field_that_is_no_number_or_comes_twice_is_refused() {
    let form = [
        ("friction", "NaN"),
        ("contacts", "inf"),
        ("seed", "1"),
        ("seed", "2"),
        ("generations", ""),
    ];
    let owned = form.map(|(name, text)| (name.to_owned(), text.to_owned()));
    let mut found: Vec<_> = PlanRequest::from_form(owned, 1)
        .unwrap_err()
        .into_iter()
        .map(|error| error.pointer)
        .collect();
    found.sort();
    assert_eq!(found, ["/contacts", "/friction", "/generations", "/seed"]);
}
