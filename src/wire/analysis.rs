//! What is told of a grasp only when it is asked for.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::read::{MAX_COORDINATE, Reader};

/// Most samples that a grasp is scattered into.
const MAX_SAMPLES: u64 = 10_000;
/// Most task wrenches of a request.
const MAX_TASKS: usize = 256;
/// Least component that counts as a direction.
const MIN_COMPONENT: f64 = 1e-150;

/// What else is to be told of a grasp. Documented where a [`PlanRequest`](super::PlanRequest) has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Analyses {
    pub robustness: Option<RobustnessSettings>,
    pub independent_regions: Option<RegionSettings>,
    pub task_wrenches: Option<Vec<[f64; 6]>>,
    pub gravity: Option<[f64; 3]>,
}

/// How the contacts of a grasp are scattered to see how robust it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RobustnessSettings {
    /// Standard deviation of either component of a displacement in the tangent plane, in the mesh's
    /// unit; at most the size of the mesh.
    #[schema(exclusive_minimum = 0, maximum = 1e12, example = 0.5)]
    pub sigma: f64,
    /// Scattered grasps. Default 200.
    #[schema(minimum = 1, maximum = 10_000, example = 200)]
    pub samples: u32,
    /// Fixes the displacements. Default 0.
    #[schema(minimum = 0, example = 0)]
    pub seed: u64,
}

/// What a grasp is to keep within its independent regions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RegionSettings {
    /// Share of the quality ε. Default 0.5.
    #[schema(exclusive_minimum = 0, maximum = 1, example = 0.5)]
    pub fraction: f64,
}

impl Reader<'_> {
    /// What else is to be told of a grasp.
    pub(super) fn analyses(&mut self) -> Analyses {
        let robustness = self.nested("robustness", &["sigma", "samples", "seed"], |reader| {
            RobustnessSettings {
                sigma: sigma(reader).unwrap_or_default(),
                samples: reader.integer("samples", 1..=MAX_SAMPLES).unwrap_or(200) as u32,
                seed: reader.integer("seed", 0..=u64::MAX).unwrap_or_default(),
            }
        });
        let independent_regions = self.nested("independent_regions", &["fraction"], |reader| {
            let fraction = reader.number("fraction", "above 0, up to 1", |x| x > 0.0 && x <= 1.0);
            RegionSettings {
                fraction: fraction.unwrap_or(0.5),
            }
        });
        Analyses {
            robustness,
            independent_regions,
            task_wrenches: self.task_wrenches(),
            gravity: self.gravity(),
        }
    }

    fn task_wrenches(&mut self) -> Option<Vec<[f64; 6]>> {
        let value = self.get("task_wrenches")?;
        let items = value.as_array();
        let Some(items) = items.filter(|items| (1..=MAX_TASKS).contains(&items.len())) else {
            self.fail(
                "task_wrenches",
                format!("must be a list of 1 to {MAX_TASKS} wrenches"),
            );
            return None;
        };
        let mut wrenches = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            match numbers(item).filter(is_direction) {
                Some(wrench) => wrenches.push(wrench),
                None => self.fail_at(
                    format!("/task_wrenches/{index}"),
                    "must be six numbers from -1e12 to 1e12, not all zero: a force and a torque about \
                     the centre of mass, [fx, fy, fz, tx, ty, tz]",
                ),
            }
        }
        Some(wrenches)
    }

    fn gravity(&mut self) -> Option<[f64; 3]> {
        let value = self.get("gravity")?;
        let direction = numbers(value).filter(is_direction);
        if direction.is_none() {
            self.fail(
                "gravity",
                "must be three numbers from -1e12 to 1e12, [x, y, z], not all zero",
            );
        }
        direction
    }
}

fn sigma(reader: &mut Reader) -> Option<f64> {
    if reader.get("sigma").is_none() {
        reader.fail("sigma", "a length in the unit of the mesh is wanted");
    }
    reader.number("sigma", "above 0, up to 1e12", |x| {
        x > 0.0 && x <= MAX_COORDINATE
    })
}

fn is_direction<const N: usize>(vector: &[f64; N]) -> bool {
    vector.iter().any(|x| x.abs() >= MIN_COMPONENT)
}

fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let items = value.as_array().filter(|items| items.len() == N)?;
    let mut numbers = [0.0; N];
    for (place, item) in numbers.iter_mut().zip(items) {
        *place = item.as_f64().filter(|x| x.abs() <= MAX_COORDINATE)?;
    }
    Some(numbers)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::wire::{EvaluationRequest, PlanRequest};

    #[test]
    fn defaults_are_filled_in() {
        let asked = json!({
            "robustness": {"sigma": 0.25}, "independent_regions": {},
            "task_wrenches": [[0, 0, 1, 0, 0, 0]], "gravity": [0, 0, -9.81]
        });
        let request = PlanRequest::from_json(&asked, 1).unwrap();
        let expected = Analyses {
            robustness: Some(RobustnessSettings {
                sigma: 0.25,
                samples: 200,
                seed: 0,
            }),
            independent_regions: Some(RegionSettings { fraction: 0.5 }),
            task_wrenches: Some(vec![[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]),
            gravity: Some([0.0, 0.0, -9.81]),
        };
        assert_eq!(request.analyses(), expected);
        let mut evaluation = asked;
        evaluation["grasps"] = json!([[{"triangle": 1}]]);
        let evaluation = EvaluationRequest::from_json(&evaluation).unwrap();
        assert_eq!(evaluation.analyses, expected);
        let nothing = PlanRequest::from_json(&json!({}), 1).unwrap();
        assert_eq!(nothing.analyses(), Analyses::default());
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
}
