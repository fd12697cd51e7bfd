//! The fields of a planning request: one table for forms, flags and messages.

use serde_json::Value;

/// A field of a planning request, as forms and flags need to know it.
pub struct Field {
    /// Its name in JSON and forms; flags write `-` for `_`.
    pub name: &'static str,
    /// What it is, with unit, range and default, in one line.
    pub help: &'static str,
    kind: Kind,
}

enum Kind {
    Number,
    Text,
    /// A number where the text is one, else text.
    NumberOrText,
    /// `true` or `false`.
    Boolean,
    /// `x,y,z`, with or without brackets.
    Point,
    /// A JSON document. It stays text until it is read strictly.
    Json,
    /// A JSON object where the text begins as one, else text.
    JsonOrText,
}

const fn field(name: &'static str, kind: Kind, help: &'static str) -> Field {
    Field { name, help, kind }
}

impl Field {
    /// Whether its text is always a JSON document.
    pub fn is_json(&self) -> bool {
        matches!(self.kind, Kind::Json)
    }

    /// Whether this text of it is to be read as a JSON document.
    pub fn reads_as_json(&self, text: &str) -> bool {
        match self.kind {
            Kind::Json => true,
            Kind::JsonOrText => text.trim_start().starts_with('{'),
            _ => false,
        }
    }
}

/// Every field of a planning request.
pub const FIELDS: &[Field] = &[
    field(
        "contacts",
        Kind::Number,
        "Number of contacts, 1 to 64 [default: 4 with friction, 7 without]",
    ),
    field(
        "contact_model",
        Kind::Text,
        "hard, soft or frictionless [default: hard]",
    ),
    field(
        "friction",
        Kind::Number,
        "Coefficient of friction, up to 10; 0 means frictionless [default: 0.5]",
    ),
    field(
        "cone_edges",
        Kind::Number,
        "Edges of the linearised friction cone, 3 to 32, or 0 for the round cone [default: 8]",
    ),
    field(
        "torsional_friction",
        Kind::Number,
        "Torque over force limit of soft contacts, a length in the mesh's unit [default: 1/20 of its radius]",
    ),
    field(
        "edge_norm",
        Kind::Text,
        "unit_edge or unit_normal [default: unit_edge]",
    ),
    field("wrench_space", Kind::Text, "l1 or linf [default: l1]"),
    field(
        "torque_scale",
        Kind::NumberOrText,
        "max_radius, none or a number (1/length) [default: max_radius]",
    ),
    field(
        "center_of_mass",
        Kind::Point,
        "x,y,z in the mesh's frame and unit [default: computed]",
    ),
    field(
        "units",
        Kind::Text,
        "Unit of the mesh's coordinates: m, cm, mm, um, in or ft; echoed, and used to doubt sizes",
    ),
    field(
        "candidates",
        Kind::JsonOrText,
        "Places to search: triangles, uniform or {\"kind\": \"uniform\", \"count\": 1 to 200000 [10000]} [default: triangles, or uniform for memetic where they are few or uneven]",
    ),
    field(
        "constraints",
        Kind::Json,
        "JSON, or as a flag the name of its file: where contacts may be, how far apart, how fingers come, and contacts that are given [default: none]",
    ),
    field(
        "method",
        Kind::Text,
        "memetic, modified_ga, local or random [default: memetic]",
    ),
    field(
        "population",
        Kind::Number,
        "Individuals per generation, 2 to 100000 [default: 8 for memetic, else 200]",
    ),
    field(
        "generations",
        Kind::Number,
        "Generations, 0 to 100000 [default: 25 for memetic, else 100]",
    ),
    field(
        "crossover_probability",
        Kind::Number,
        "Probability that two parents are crossed, 0 to 1 [default: 0.7 for memetic, else 0.9]",
    ),
    field(
        "mutation_probability",
        Kind::Number,
        "Probability that a child is mutated, 0 to 1 [default: 0.2]",
    ),
    field(
        "elitism",
        Kind::Number,
        "Best individuals carried over, less than the population [default: 1]",
    ),
    field(
        "initial",
        Kind::Text,
        "strict or weak form of the search for the first grasp [default: weak for memetic, else strict]",
    ),
    field(
        "polish",
        Kind::Boolean,
        "true or false: slide the contacts of the best grasp over the surface [default: true for memetic]",
    ),
    field(
        "time_limit_s",
        Kind::Number,
        "Stop after this many seconds, up to 3600 [default: none]",
    ),
    field(
        "evaluation_limit",
        Kind::Number,
        "Stop after this many quality evaluations, up to 1e9 [default: none]",
    ),
    field(
        "target_quality",
        Kind::Number,
        "Stop once this quality is reached [default: none]",
    ),
    field(
        "robustness",
        Kind::Json,
        "Scatter the contacts of the grasp found: {\"sigma\": length, \"samples\": 1 to 10000 [200], \"seed\": [0]}",
    ),
    field(
        "independent_regions",
        Kind::Json,
        "Where each finger may be while the others stay: {\"fraction\": share of the quality to keep [0.5]}",
    ),
    field(
        "task_wrenches",
        Kind::Json,
        "Disturbances to tell the quality against: [[fx,fy,fz,tx,ty,tz], ...], up to 256",
    ),
    field(
        "gravity",
        Kind::Point,
        "x,y,z of a force at the centre of mass to tell the quality against",
    ),
    field(
        "seed",
        Kind::Number,
        "Fixes every random choice; 0 to 2^64-1 [default: random]",
    ),
    field(
        "trials",
        Kind::Number,
        "Repeat with seeds seed, seed+1, ... and tell statistics, 1 to 1000 [default: 1]",
    ),
    field(
        "top",
        Kind::Number,
        "Distinct grasps to tell, 1 to 100 [default: 1]",
    ),
    field(
        "label",
        Kind::Text,
        "A name for the job, up to 200 characters",
    ),
    field(
        "priority",
        Kind::Text,
        "interactive or batch: whether the job goes before others in the queue [default: interactive]",
    ),
    field(
        "callback_url",
        Kind::Text,
        "Where the server posts a signed message once the job has ended",
    ),
];

/// Names of the fields that say how a server is to treat the job: a run without a server has no use for them.
pub const JOB_FIELDS: &[&str] = &["priority", "callback_url"];

/// What a form may say of its mesh file beside the fields of the request.
const FILE_FIELDS: &[Field] = &[
    field(
        "format",
        Kind::Text,
        "Format of the file [default: its content tells]",
    ),
    field(
        "scale",
        Kind::Number,
        "What the coordinates of the file are multiplied by, 1e-9 to 1e9 [default: 1]",
    ),
];

/// Names of the fields that the quality of a grasp depends on: those of an evaluation.
pub const QUALITY_FIELDS: &[&str] = &[
    "contact_model",
    "friction",
    "cone_edges",
    "torsional_friction",
    "edge_norm",
    "wrench_space",
    "torque_scale",
    "center_of_mass",
    "units",
];

/// Names of the fields that ask for more to be told of a grasp: an evaluation has them too.
pub const ANALYSIS_FIELDS: &[&str] = &[
    "robustness",
    "independent_regions",
    "task_wrenches",
    "gravity",
];

/// The JSON value that a form field or flag means; one that its field cannot take stays text, for
/// the validation to refuse.
pub fn form_value(name: &str, text: &str) -> Value {
    let as_text = || Value::String(text.to_owned());
    let mut known = FIELDS.iter().chain(FILE_FIELDS);
    let Some(field) = known.find(|field| field.name == name) else {
        return as_text();
    };
    match field.kind {
        Kind::Text | Kind::Json | Kind::JsonOrText => as_text(),
        Kind::Boolean => text.parse().map_or_else(|_| as_text(), Value::Bool),
        Kind::Number | Kind::NumberOrText => number(text)
            .or_else(|| serde_json::from_str(text).ok().filter(Value::is_array))
            .unwrap_or_else(as_text),
        Kind::Point => {
            let inner = text.trim();
            let inner = inner
                .strip_prefix('[')
                .and_then(|rest| rest.strip_suffix(']'))
                .unwrap_or(inner);
            inner
                .split(',')
                .map(number)
                .collect::<Option<Vec<_>>>()
                .map_or_else(as_text, Value::Array)
        }
    }
}

/// The number `text` spells; integers stay exact over the whole range of a seed.
fn number(text: &str) -> Option<Value> {
    let text = text.trim();
    text.parse::<u64>()
        .map(Value::from)
        .ok()
        .or_else(|| text.parse::<f64>().ok().and_then(finite))
}

fn finite(value: f64) -> Option<Value> {
    serde_json::Number::from_f64(value).map(Value::Number)
}
