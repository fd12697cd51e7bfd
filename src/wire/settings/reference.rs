//! All settings of a planning request as a table for people, and as data for the page.

use std::fmt::Write;

use serde::Serialize;

use super::definition::{Choice, Kind, List, Object, Scope, Setting};
use super::describe::{default_in_words, words};
use super::table::{FILE_SETTINGS, SETTINGS};

/// The settings in Markdown, those of nested objects after the others.
pub fn markdown() -> String {
    let mut page = table(SETTINGS);
    for setting in SETTINGS {
        write_choices(setting, &mut page);
    }
    let mut objects = Vec::new();
    for setting in SETTINGS {
        collect_objects(setting.name, &setting.kind, &mut objects);
    }
    for (path, members) in objects {
        let _ = write!(page, "\n### Members of `{path}`\n\n{}", table(members));
    }
    let _ = write!(page, "\n## Of a mesh file\n\n{}", table(FILE_SETTINGS));
    page
}

fn table(settings: &[Setting]) -> String {
    let mut table = "| setting | value | default | meaning |\n|---|---|---|---|\n".to_owned();
    for setting in settings {
        let unit = match setting.unit {
            "" => String::new(),
            unit => format!(", in {unit}"),
        };
        let default = default_in_words(setting).unwrap_or("required");
        let value = words(&setting.kind).replace('"', "`");
        let (name, help) = (setting.name, setting.help);
        let _ = writeln!(table, "| `{name}` | {value}{unit} | {default} | {help} |");
    }
    table
}

fn write_choices(setting: &Setting, page: &mut String) {
    let (Kind::Choice(choice) | Kind::NameOr(choice, _)) = setting.kind else {
        return;
    };
    let _ = write!(page, "\n### Values of `{}`\n\n", setting.name);
    for (name, meaning) in choice.names {
        let _ = writeln!(page, "- `{name}`: {meaning}");
    }
}

/// The objects within a setting, each with the path to it.
fn collect_objects(path: &str, kind: &Kind, found: &mut Vec<(String, &'static [Setting])>) {
    let members = match kind {
        Kind::NameOr(_, other) => return collect_objects(path, other, found),
        Kind::List(List { of, .. }) => return collect_objects(path, of, found),
        Kind::Object(Object { members, .. }) | Kind::OneOf { members, .. } => *members,
        _ => return,
    };
    if found.iter().any(|(_, known)| std::ptr::eq(*known, members)) {
        return;
    }
    found.push((path.to_owned(), members));
    for member in members {
        collect_objects(&format!("{path}.{}", member.name), &member.kind, found);
    }
}

/// A setting as the page knows it.
#[derive(Serialize)]
struct Described {
    name: &'static str,
    kind: &'static str,
    help: &'static str,
    /// In words.
    default: &'static str,
    unit: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    min: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max: Option<f64>,
    /// Names with what they stand for.
    choices: &'static [(&'static str, &'static str)],
}

/// The settings of a planning request that have a value of one number, text or name, in JSON.
pub fn json() -> serde_json::Result<String> {
    let of_run = SETTINGS
        .iter()
        .filter(|setting| setting.scope != Scope::Job);
    let described: Vec<Described> = of_run.filter_map(described).collect();
    serde_json::to_string_pretty(&described).map(|text| text + "\n")
}

fn described(setting: &Setting) -> Option<Described> {
    let (kind, min, max) = match setting.kind {
        // A number beyond 2^53 is not exact on the page.
        Kind::Whole {
            max: u64::MAX, min, ..
        } => ("integer", Some(min as f64), None),
        Kind::Whole { min, max, or_zero } => {
            let min = if or_zero { 0 } else { min };
            ("integer", Some(min as f64), Some(max as f64))
        }
        Kind::Number(range) => {
            let max = range.max.is_finite().then_some(range.max);
            ("number", Some(range.min), max)
        }
        Kind::Choice(_) => ("choice", None, None),
        Kind::Text { .. } => ("text", None, None),
        Kind::NameOr(_, Kind::Number(_)) => ("name or number", None, None),
        _ => return None,
    };
    let choices = match setting.kind {
        Kind::Choice(Choice { names, .. }) | Kind::NameOr(Choice { names, .. }, _) => names,
        _ => &[],
    };
    Some(Described {
        name: setting.name,
        kind,
        help: setting.help,
        default: default_in_words(setting).unwrap_or_default(),
        unit: setting.unit,
        min,
        max,
        choices,
    })
}
