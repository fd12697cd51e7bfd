//! Constraints on where contacts may be and how far apart, as a request has them.

use serde::{Deserialize, Serialize};

use super::contact::ContactSpec;
use super::region::Region;

/// What every grasp has to satisfy. What each member means stands in [`SETTINGS`](super::settings::SETTINGS).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Constraints {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub include: Vec<Region>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exclude: Vec<Region>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_contact_distance: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_contact_distance: Option<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub approach_directions: Vec<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_normal_angle: Option<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fixed_contacts: Vec<ContactSpec>,
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use crate::wire::PlanRequest;

    fn pointers(constraints: Value) -> Vec<String> {
        let request = json!({"contacts": 3, "constraints": constraints});
        let faults = PlanRequest::from_json(&request, 1).expect_err("refused");
        faults.into_iter().map(|fault| fault.pointer).collect()
    }

    #[test]
    fn every_kind_is_read_and_written_again() {
        let constraints = json!({
            "include": [
                {"box": {"min": [0.0, 0.0, 0.0], "max": [1.0, 0.0, 2.0]}},
                {"half_space": {"point": [0.0, 1.0, 2.0], "normal": [0.0, 0.0, -3.0]}}
            ],
            "exclude": [
                {"sphere": {"center": [0.5, 0.0, 0.0], "radius": 2.5}},
                {"triangles": [7, 1, 7]}
            ],
            "min_contact_distance": 0.0,
            "max_contact_distance": 1.5,
            "approach_directions": [[0.0, 0.0, -1.0], [2.0, 0.0, 0.0]],
            "max_normal_angle": 60.0,
            "fixed_contacts": [{"triangle": 3}, {"point": [0.0, 1.0, 2.0], "normal": [1.0, 0.0, 0.0]}]
        });
        let request = json!({"contacts": 3, "constraints": constraints});
        let read = PlanRequest::from_json(&request, 1).unwrap();
        let written = serde_json::to_value(&read).unwrap();
        assert_eq!(written["constraints"], constraints);
        assert_eq!(
            serde_json::from_value::<PlanRequest>(written).unwrap(),
            read
        );
        let form = [
            ("contacts", "3".to_owned()),
            ("constraints", constraints.to_string()),
        ];
        let form = form.map(|(name, text)| (name.to_owned(), text));
        assert_eq!(PlanRequest::from_form(form, 1).unwrap(), read);
    }

    #[test]
    fn faults_are_told_with_their_place() {
        let many: Vec<Value> = vec![json!({"triangles": []}); 65];
        for (constraints, pointer) in [
            (json!(null), "/constraints"),
            (json!([]), "/constraints"),
            (json!({"includes": []}), "/constraints/includes"),
            (json!({"include": {}}), "/constraints/include"),
            (json!({"exclude": many}), "/constraints/exclude"),
            (json!({"exclude": [7]}), "/constraints/exclude/0"),
            (json!({"exclude": [{}]}), "/constraints/exclude/0"),
            (
                json!({"exclude": [{"cube": 1}]}),
                "/constraints/exclude/0/cube",
            ),
            (
                json!({"exclude": [{"box": 1}]}),
                "/constraints/exclude/0/box",
            ),
            (
                json!({"exclude": [{"box": {"min": [0, 0, 0]}}]}),
                "/constraints/exclude/0/box/max",
            ),
            (
                json!({"exclude": [{"box": {"min": [0, 1, 0], "max": [1, 0, 1]}}]}),
                "/constraints/exclude/0/box/min",
            ),
            (
                json!({"include": [{"box": {"min": [0, 0, 0], "max": [1, "a", 1]}}]}),
                "/constraints/include/0/box/max/1",
            ),
            (
                json!({"include": [{"half_space": {"point": [0, 0, 0], "normal": [0, 0, 0]}}]}),
                "/constraints/include/0/half_space/normal",
            ),
            (
                json!({"include": [{"sphere": {"center": [0, 0, 0], "radius": 0}}]}),
                "/constraints/include/0/sphere/radius",
            ),
            (
                json!({"include": [{"sphere": {"center": [0, 0, 0], "radius": 1, "r": 2}}]}),
                "/constraints/include/0/sphere/r",
            ),
            (
                json!({"include": [{"triangles": [0, -1]}]}),
                "/constraints/include/0/triangles/1",
            ),
            (
                json!({"include": [{"triangles": vec![0; 60_000]}, {"triangles": vec![0; 60_000]}]}),
                "/constraints/include/1/triangles",
            ),
            (
                json!({"min_contact_distance": -1}),
                "/constraints/min_contact_distance",
            ),
            (
                json!({"max_contact_distance": 0}),
                "/constraints/max_contact_distance",
            ),
            (
                json!({"min_contact_distance": 2, "max_contact_distance": 1}),
                "/constraints/min_contact_distance",
            ),
            (
                json!({"max_normal_angle": 30}),
                "/constraints/max_normal_angle",
            ),
            (
                json!({"approach_directions": [[0, 0, 1]]}),
                "/constraints/approach_directions",
            ),
            (
                json!({"approach_directions": [], "max_normal_angle": 30}),
                "/constraints/approach_directions",
            ),
            (
                json!({"approach_directions": [[0, 0, 1], [0, 0, 0]], "max_normal_angle": 30}),
                "/constraints/approach_directions/1",
            ),
            (
                json!({"approach_directions": [[0, 0, 1]], "max_normal_angle": 181}),
                "/constraints/max_normal_angle",
            ),
            (
                json!({"fixed_contacts": [{"triangle": 1}, {"triangle": 2}, {"triangle": 3}]}),
                "/constraints/fixed_contacts",
            ),
            (
                json!({"fixed_contacts": [{"triangle": -1}]}),
                "/constraints/fixed_contacts/0/triangle",
            ),
            (
                json!({"fixed_contacts": [{"point": [0, 0, 0], "normal": [0, 0, 0]}]}),
                "/constraints/fixed_contacts/0/normal",
            ),
        ] {
            assert_eq!(pointers(constraints.clone()), [pointer], "{constraints}");
        }
    }

    #[test]
    fn a_form_field_that_is_no_json_is_refused() {
        for text in ["", "{", "{} x", r#"{"include": [], "include": []}"#] {
            let form = [("constraints".to_owned(), text.to_owned())];
            let faults = PlanRequest::from_form(form, 1).unwrap_err();
            assert_eq!(faults[0].pointer, "/constraints", "{text}");
        }
    }
}
