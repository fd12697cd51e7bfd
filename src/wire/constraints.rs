//! Constraints on where contacts may be and how far apart, as a client says them.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use super::contact::{COORDINATES, ContactSpec, vector};
use super::read::{MAX_COORDINATE, Reader};
use super::region::{MAX_TRIANGLES, Region, is_zero, region};

/// Most bytes of the JSON of the constraints where they come from a file; over HTTP a whole request has
/// less.
pub const MAX_CONSTRAINTS_BYTES: usize = 1 << 20;
/// Most regions, included and excluded together.
const MAX_REGIONS: usize = 64;
/// Most approach directions.
const MAX_DIRECTIONS: usize = 64;

/// What every grasp has to keep. A place on the surface may be a contact if it is in some region of
/// `include`, when that names any, and in none of `exclude`; places are decided about by their position,
/// the centroid of a triangle, and borders belong to their region.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Constraints {
    /// Regions to be in. Default: the whole surface.
    #[schema(max_items = 64)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub include: Vec<Region>,
    /// Regions not to be in. Both lists together have at most 64 regions.
    #[schema(max_items = 64)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exclude: Vec<Region>,
    /// Least distance between any two contacts, in the mesh's unit.
    #[schema(minimum = 0, maximum = 1e12, nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_contact_distance: Option<f64>,
    /// Greatest distance between any two contacts, the span of the hand, in the mesh's unit.
    #[schema(exclusive_minimum = 0, maximum = 1e12, nullable = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_contact_distance: Option<f64>,
    /// Directions in which a finger moves towards the body, of any length but zero.
    #[schema(max_items = 64)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub approach_directions: Vec<[f64; 3]>,
    /// Greatest angle between the inward normal of a contact and the nearest approach direction, degrees.
    #[schema(minimum = 0, maximum = 180, nullable = false, example = 60.0)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_normal_angle: Option<f64>,
    /// Contacts that are part of every grasp, fewer than `contacts`; the rest are planned. Among
    /// themselves they are taken as given.
    #[schema(max_items = 63)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fixed_contacts: Vec<ContactSpec>,
}

const MEMBERS: [&str; 7] = [
    "include",
    "exclude",
    "min_contact_distance",
    "max_contact_distance",
    "approach_directions",
    "max_normal_angle",
    "fixed_contacts",
];

impl Constraints {
    /// Takes the constraints out of a request for grasps of so many contacts, if it has any, and reports
    /// what is wrong with them.
    pub(super) fn read(request: &mut Reader, contacts: u64) -> Option<Self> {
        let value = request.value("constraints")?;
        let Some(object) = value.as_object() else {
            request.fail("constraints", "must be a JSON object");
            return None;
        };
        let mut reader = Reader::within(object, request.pointer("constraints"));
        reader.refuse_unknown(&MEMBERS);
        let mut left = MAX_TRIANGLES;
        let include = regions(&mut reader, "include", MAX_REGIONS, &mut left);
        let most = MAX_REGIONS - include.len();
        let read = Self {
            exclude: regions(&mut reader, "exclude", most, &mut left),
            include,
            min_contact_distance: reader.number("min_contact_distance", "from 0 to 1e12", |x| {
                (0.0..=MAX_COORDINATE).contains(&x)
            }),
            max_contact_distance: reader.number(
                "max_contact_distance",
                "above 0, up to 1e12",
                |x| x > 0.0 && x <= MAX_COORDINATE,
            ),
            approach_directions: directions(&mut reader),
            max_normal_angle: reader.number("max_normal_angle", "of degrees, 0 to 180", |x| {
                (0.0..=180.0).contains(&x)
            }),
            fixed_contacts: fixed_contacts(&mut reader, contacts),
        };
        read.refuse_contradictions(&mut reader);
        request.absorb(reader);
        Some(read)
    }

    fn refuse_contradictions(&self, reader: &mut Reader) {
        if let (Some(min), Some(max)) = (self.min_contact_distance, self.max_contact_distance)
            && min > max
        {
            let detail = "must not be greater than max_contact_distance";
            reader.fail("min_contact_distance", detail);
        }
        let given = |name| reader.value(name).is_some();
        match (given("approach_directions"), given("max_normal_angle")) {
            (true, false) => reader.fail(
                "approach_directions",
                "goes with max_normal_angle; give both or none",
            ),
            (false, true) => reader.fail(
                "max_normal_angle",
                "goes with approach_directions; give both or none",
            ),
            (true, true) | (false, false) => {}
        }
    }
}

/// The items of a list of at most `most`.
fn list<'a>(reader: &mut Reader<'a>, name: &str, most: usize) -> &'a [Value] {
    let Some(value) = reader.value(name) else {
        return &[];
    };
    match value.as_array().filter(|items| items.len() <= most) {
        Some(items) => items,
        None => {
            reader.fail(name, format!("must be a list of at most {most}"));
            &[]
        }
    }
}

fn regions(reader: &mut Reader, name: &str, most: usize, triangles: &mut usize) -> Vec<Region> {
    let items = list(reader, name, most).iter().enumerate();
    items
        .filter_map(|(i, item)| {
            let place = format!("{}/{i}", reader.pointer(name));
            region(reader, place, item, triangles)
        })
        .collect()
}

fn directions(reader: &mut Reader) -> Vec<[f64; 3]> {
    let name = "approach_directions";
    let items = list(reader, name, MAX_DIRECTIONS);
    if items.is_empty() && reader.value(name).is_some_and(Value::is_array) {
        reader.fail(name, format!("must be a list of 1 to {MAX_DIRECTIONS}"));
    }
    let mut directions = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        let place = format!("{}/{i}", reader.pointer(name));
        match vector(item) {
            Some(direction) if is_zero(&direction) => reader.fail_at(place, "must not be zero"),
            Some(direction) => directions.push(direction),
            None => reader.fail_at(place, COORDINATES),
        }
    }
    directions
}

fn fixed_contacts(reader: &mut Reader, contacts: u64) -> Vec<ContactSpec> {
    let name = "fixed_contacts";
    let Some(value) = reader.value(name) else {
        return Vec::new();
    };
    let fewer = |items: &&Vec<Value>| (items.len() as u64) < contacts;
    let Some(items) = value.as_array().filter(fewer) else {
        let detail = format!(
            "must be a list of fewer contacts than the grasp has, {contacts} with the planned ones"
        );
        reader.fail(name, detail);
        return Vec::new();
    };
    let mut fixed = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        match ContactSpec::read(item) {
            Ok(contact) => fixed.push(contact),
            Err((member, detail)) => {
                reader.fail_at(format!("{}/{i}{member}", reader.pointer(name)), detail);
            }
        }
    }
    fixed
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
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
