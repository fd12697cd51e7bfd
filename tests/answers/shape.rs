//! Answers as text for a snapshot: a line for each member, without times and ids, and with the digits that every
//! processor agrees on.

use serde_json::{Number, Value};

/// Digits that are kept. The sine of one processor may differ from that of another in the last.
const DIGITS: usize = 9;
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
        text += &format!("{name}: {}\n", kept(name, value));
    }
    text
}

/// The faults of a refused request.
pub fn refusal(status: u16, answer: &Value) -> String {
    let mut text = format!("  {status} {}", kept("detail", &answer["detail"]));
    for fault in answer["errors"].as_array().into_iter().flatten() {
        text += &format!("\n  {fault}");
    }
    text
}

/// The part of a value that does not vary.
fn kept(name: &str, value: &Value) -> Value {
    match value {
        _ if VARYING.contains(&name) => "…".into(),
        Value::Number(number) => rounded(number),
        Value::Array(values) if values.len() > LONG => {
            let shown = values[..3].iter().map(|value| kept("", value));
            let count = format!("… {} in all", values.len());
            shown.chain([count.into()]).collect()
        }
        Value::Array(values) => values.iter().map(|value| kept("", value)).collect(),
        Value::Object(members) => members
            .iter()
            .map(|(name, value)| (name.clone(), kept(name, value)))
            .collect(),
        other => other.clone(),
    }
}

fn rounded(number: &Number) -> Value {
    match number.as_f64() {
        Some(value) if number.is_f64() => {
            let text = format!("{value:.*e}", DIGITS - 1);
            let short: f64 = text.parse().expect("a number");
            // What is left of a difference of equal numbers is noise.
            if short.abs() < 1e-12 { 0.0 } else { short }.into()
        }
        _ => Value::Number(number.clone()),
    }
}
