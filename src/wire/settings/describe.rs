//! Settings in words: for messages, flags and the reference.

use std::fmt::Write;

use super::definition::{Choice, Default, Kind, Object, Range, Setting, Vector};

/// What a value of this kind must be, as it follows "must be".
pub fn words(kind: &Kind) -> String {
    match kind {
        Kind::Whole { min, max, or_zero } => {
            let zero = if *or_zero { "0 or " } else { "" };
            format!("{zero}a whole number from {min} to {max}")
        }
        Kind::Number(range) => range_in_words(range),
        Kind::Boolean => "true or false".to_owned(),
        Kind::Choice(choice) => listed(quoted(choice)),
        Kind::NameOr(choice, other) => {
            let other = match other {
                Kind::Object(object) => format!("an object with {}", all_names(object.members)),
                other => words(other),
            };
            listed(quoted(choice).chain([other]))
        }
        Kind::Text { max_chars } => format!(
            "a text of at most {max_chars} characters without control characters or marks that change \
             the direction of writing"
        ),
        Kind::Url { max_bytes } => {
            format!("a URL of at most {max_bytes} bytes without control characters")
        }
        Kind::Vector(Vector {
            length,
            is_direction,
            shape,
            ..
        }) => {
            let count = if *length == 3 { "three" } else { "six" };
            let zero = if *is_direction { ", not all zero" } else { "" };
            format!("{count} numbers from -1e12 to 1e12{zero}: {shape}")
        }
        Kind::List(list) => {
            let (min, max, what) = (list.min, list.max, list.what);
            match min {
                0 => format!("a list of at most {max} {what}"),
                _ => format!("a list of {min} to {max} {what}"),
            }
        }
        Kind::Object(Object { members, .. }) => format!("an object with {}", all_names(members)),
        Kind::OneOf { members, .. } => format!("an object with one member: {}", names(members)),
        Kind::Triangles { max } => {
            format!("a list of at most {max} numbers of triangles, counted from 0")
        }
        Kind::Contact => "a contact: a triangle, a point, or a point with a normal".to_owned(),
        Kind::Component => {
            "`all`, the number of a body, counted from 0, or the name of a part of the file"
                .to_owned()
        }
        Kind::Document => "a JSON document".to_owned(),
    }
}

fn range_in_words(range: &Range) -> String {
    let (min, max) = (short(range.min), short(range.max));
    match (range.above, range.max.is_finite()) {
        (false, true) => format!("a number from {min} to {max}"),
        (true, true) => format!("a number above {min}, up to {max}"),
        (false, false) => format!("a number from {min} up"),
        (true, false) => format!("a number above {min}"),
    }
}

/// A bound as people write it.
fn short(bound: f64) -> String {
    match bound.abs() {
        0.0 | 1e-3..1e6 => bound.to_string(),
        _ => format!("{bound:e}"),
    }
}

fn quoted(choice: &Choice) -> impl Iterator<Item = String> {
    choice.names.iter().map(|(name, _)| format!("\"{name}\""))
}

fn names(members: &[Setting]) -> String {
    listed(members.iter().map(|member| member.name.to_owned()))
}

/// `a, b and c`.
fn all_names(members: &[Setting]) -> String {
    let names: Vec<&str> = members.iter().map(|member| member.name).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

/// `a, b or c`.
pub fn listed(items: impl Iterator<Item = String>) -> String {
    let mut items: Vec<String> = items.collect();
    match items.pop() {
        Some(last) if !items.is_empty() => format!("{} or {last}", items.join(", ")),
        last => last.unwrap_or_default(),
    }
}

/// The default in words.
pub fn default_in_words(setting: &Setting) -> Option<&'static str> {
    match setting.default {
        Default::Required => None,
        Default::Absent(text) | Default::From { text, .. } => Some(text),
        Default::Value(json) => Some(json.trim_matches('"')),
    }
}

/// The line about a setting in the help of a command.
pub fn flag_help(setting: &Setting) -> String {
    let (first, _) = setting.help.split_once(". ").unwrap_or((setting.help, ""));
    let mut help = first.trim_end_matches('.').to_owned();
    let range = words(&setting.kind).replace('"', "");
    // A label and a URL say enough by themselves.
    if !matches!(setting.kind, Kind::Text { .. } | Kind::Url { .. }) {
        let _ = write!(help, ": {range}");
    }
    if setting.is_document() {
        help.push_str(", in JSON, or the name of a file that holds it");
    }
    if !setting.unit.is_empty() {
        let _ = write!(help, ", in {}", setting.unit);
    }
    if let Some(default) = default_in_words(setting) {
        let _ = write!(help, " [default: {default}]");
    }
    help
}
