//! What the settings of a request mean for each other: defaults that follow from other settings, and what
//! must hold between them.

use serde_json::{Map, Value};

use super::checked::Checked;

/// Most regions of each list; both lists together may have no more.
pub const MAX_REGIONS: usize = 64;
/// Most triangles that all regions of a request may name.
pub const MAX_TRIANGLES: usize = 100_000;
/// Individuals that one request may ask for: population times (generations + 1).
const MAX_INDIVIDUALS: f64 = 1e9;
/// Candidates that are spread over a surface unless a request says how many.
pub const UNIFORM_COUNT: u32 = 10_000;

/// Nothing has to hold.
pub fn none(_: &mut Checked<'_>) {}

/// What must hold between the settings of a planning request.
pub fn request(checked: &mut Checked<'_>) {
    contact(checked);
    let number = |name| checked.number(name).unwrap_or_default();
    let (population, elitism) = (number("population"), number("elitism"));
    if population * (number("generations") + 1.0) > MAX_INDIVIDUALS {
        checked.fail(
            "generations",
            "population times (generations + 1) must be at most 1000000000",
        );
    }
    if elitism >= population {
        checked.fail("elitism", "must be less than the population");
    }
    fixed_contacts(checked);
}

/// Frictionless contacts have no friction and no cone, and only soft ones have torsional friction. What
/// frictionless contacts do not have is taken out.
pub fn contact(checked: &mut Checked<'_>) {
    let is_soft = checked.name("contact_model") == Some("soft");
    if checked.given("torsional_friction").is_some() && !is_soft {
        checked.fail(
            "torsional_friction",
            "only soft contacts have it; leave it out or use contact_model \"soft\"",
        );
    }
    if is_soft && checked.number("friction") == Some(0.0) {
        checked.fail("friction", "soft contacts need some; use a number above 0");
    }
    if !is_frictionless(&checked.read) {
        return;
    }
    if checked
        .number("friction")
        .is_some_and(|friction| friction > 0.0)
    {
        checked.fail(
            "friction",
            "frictionless contacts have none; leave it out or use contact_model \"hard\"",
        );
    }
    if checked.given("cone_edges").is_some() {
        checked.fail(
            "cone_edges",
            "frictionless contacts have no friction cone; leave it out",
        );
    }
    checked
        .read
        .insert("contact_model".to_owned(), "frictionless".into());
    checked.read.remove("friction");
    checked.read.remove("cone_edges");
}

fn is_frictionless(read: &Map<String, Value>) -> bool {
    let model = read.get("contact_model").and_then(Value::as_str);
    let friction = read.get("friction").and_then(Value::as_f64);
    model == Some("frictionless") || (friction == Some(0.0) && model != Some("soft"))
}

/// Frictionless where there is no friction, else hard.
pub fn contact_model_default(read: &Map<String, Value>) -> Option<Value> {
    let name = if is_frictionless(read) {
        "frictionless"
    } else {
        "hard"
    };
    Some(name.into())
}

/// As many as are usual.
pub fn contacts_default(read: &Map<String, Value>) -> Option<Value> {
    Some(if is_frictionless(read) { 7 } else { 4 }.into())
}

/// A value that frictionless contacts do not have.
pub fn with_friction(read: &Map<String, Value>, value: impl Into<Value>) -> Option<Value> {
    (!is_frictionless(read)).then(|| value.into())
}

/// One value for `memetic`, the default, and another for other methods.
pub fn by_method<T: Into<Value>>(read: &Map<String, Value>, memetic: T, other: T) -> Option<Value> {
    let method = read.get("method").and_then(Value::as_str);
    let value = if method.is_none_or(|method| method == "memetic") {
        memetic
    } else {
        other
    };
    Some(value.into())
}

/// How many candidates are spread over the surface unless that is given.
pub fn uniform_count(read: &Map<String, Value>) -> Option<Value> {
    let is_uniform = read.get("kind").and_then(Value::as_str) == Some("uniform");
    is_uniform.then(|| UNIFORM_COUNT.into())
}

/// Only uniform candidates can be counted.
pub fn candidates(checked: &mut Checked<'_>) {
    if checked.name("kind") == Some("triangles") && checked.given("count").is_some() {
        checked.fail(
            "count",
            "every triangle is a candidate; leave it out or use uniform",
        );
    }
}

/// The lowest corner of a box is the lowest.
pub fn corners(checked: &mut Checked<'_>) {
    let pairs = checked.list("min").iter().zip(checked.list("max"));
    if pairs
        .into_iter()
        .any(|(min, max)| min.as_f64() > max.as_f64())
    {
        checked.fail(
            "min",
            "must not be greater than max on any axis: the box is empty",
        );
    }
}

/// What must hold between constraints, whatever the grasps are.
pub fn constraints(checked: &mut Checked<'_>) {
    let (included, excluded) = (checked.list("include").len(), checked.list("exclude").len());
    if included + excluded > MAX_REGIONS {
        let detail = format!(
            "must be a list of at most {} regions",
            MAX_REGIONS - included
        );
        checked.fail("exclude", detail);
    }
    let mut triangles = 0;
    for name in ["include", "exclude"] {
        for i in 0..checked.list(name).len() {
            let named = checked.list(name)[i]["triangles"]
                .as_array()
                .map_or(0, Vec::len);
            if triangles + named > MAX_TRIANGLES {
                let detail = format!("all regions together may name {MAX_TRIANGLES} triangles");
                checked.fail(&format!("{name}/{i}/triangles"), detail);
            } else {
                triangles += named;
            }
        }
    }
    let distance = |name| checked.number(name);
    let (min, max) = (
        distance("min_contact_distance"),
        distance("max_contact_distance"),
    );
    if let (Some(min), Some(max)) = (min, max)
        && min > max
    {
        checked.fail(
            "min_contact_distance",
            "must not be greater than max_contact_distance",
        );
    }
    let (directions, angle) = ("approach_directions", "max_normal_angle");
    match (checked.is_given(directions), checked.is_given(angle)) {
        (true, false) => {
            checked.fail(directions, "goes with max_normal_angle; give both or none");
        }
        (false, true) => {
            checked.fail(angle, "goes with approach_directions; give both or none");
        }
        (true, true) | (false, false) => {}
    }
}

/// Fewer contacts are fixed than a grasp has, so that some are left to plan. Where there are too many, that is
/// all that is reported about them.
fn fixed_contacts(checked: &mut Checked<'_>) {
    let contacts = checked.number("contacts").unwrap_or_default();
    let constraints = checked.as_given("constraints");
    let fixed = constraints.and_then(|constraints| constraints["fixed_contacts"].as_array());
    if fixed.is_some_and(|fixed| fixed.len() as f64 >= contacts) {
        let detail = format!(
            "must be a list of fewer contacts than the grasp has, {contacts} with the planned ones"
        );
        checked.fail_alone("constraints/fixed_contacts", detail);
    }
}
