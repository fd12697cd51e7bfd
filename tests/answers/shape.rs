//! Answers as text for a snapshot: a line for each member, without times and ids, and with the digits that every
//! processor agrees on.

use serde_json::{Number, Value};

/// How much of a number is kept.
#[derive(Clone, Copy)]
struct Precision {
    digits: usize,
    /// Less than this is what is left of a difference of equal numbers.
    noise: f64,
}

/// The sine of one processor may differ from that of another in the last digit.
const USUAL: Precision = Precision {
    digits: 9,
    noise: 1e-12,
};
/// Forces come from a cone program, which stops within a tolerance of its optimum.
const FORCES: Precision = Precision {
    digits: 4,
    noise: 1e-6,
};
/// A list of more numbers than this is shortened.
const LONG: usize = 64;
/// Members whose value differs from run to run.
const VARYING: [&str; 8] = [
    "elapsed_s",
    "id",
    "job_id",
    "mesh_id",
    "instance",
    "incident",
    "created_at",
    "version",
];

/// A status and a JSON object.
pub fn answer(status: u16, answer: &Value) -> String {
    let mut text = format!("{status}\n");
    for (name, value) in answer.as_object().expect("an object") {
        text += &format!("{name}: {}\n", member(name, value, USUAL));
    }
    text
}

/// The faults of a refused request.
pub fn refusal(status: u16, answer: &Value) -> String {
    let mut text = format!("  {status} {}", answer["detail"]);
    for fault in answer["errors"].as_array().into_iter().flatten() {
        text += &format!("\n  {fault}");
    }
    text
}

/// What is kept of a member of an object.
fn member(name: &str, value: &Value, precision: Precision) -> Value {
    match name {
        _ if VARYING.contains(&name) => "…".into(),
        "forces" => kept(value, FORCES),
        _ => kept(value, precision),
    }
}

/// What is kept of a value.
fn kept(value: &Value, precision: Precision) -> Value {
    match value {
        Value::Number(number) => rounded(number, precision),
        Value::Array(values) if values.len() > LONG => {
            let shown = values[..3].iter().map(|value| kept(value, precision));
            let count = format!("… {} in all", values.len());
            shown.chain([count.into()]).collect()
        }
        Value::Array(values) => values.iter().map(|value| kept(value, precision)).collect(),
        Value::Object(members) => members
            .iter()
            .map(|(name, value)| (name.clone(), member(name, value, precision)))
            .collect(),
        other => other.clone(),
    }
}

fn rounded(number: &Number, Precision { digits, noise }: Precision) -> Value {
    match number.as_f64() {
        Some(value) if number.is_f64() => {
            let text = format!("{value:.*e}", digits - 1);
            let short: f64 = text.parse().expect("a number");
            if short.abs() < noise { 0.0 } else { short }.into()
        }
        _ => Value::Number(number.clone()),
    }
}
