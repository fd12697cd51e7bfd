//! Settings as text: the fields of forms, and flags.

use serde_json::{Map, Value};

use super::checked::fault;
use super::definition::{Kind, Setting};
use crate::wire::{FieldError, json, text};

/// Most bytes of a JSON document in a form field or a file that a flag names; over HTTP a whole request has
/// less.
pub const MAX_DOCUMENT_BYTES: usize = 1 << 20;

impl Setting {
    /// Whether its text is always a JSON document.
    pub fn is_document(&self) -> bool {
        matches!(
            self.kind,
            Kind::List(_)
                | Kind::Object(_)
                | Kind::OneOf { .. }
                | Kind::Triangles { .. }
                | Kind::Contact
                | Kind::Document
        )
    }

    /// Whether this text is to be read as a JSON document.
    fn reads_as_document(&self, text: &str) -> bool {
        match self.kind {
            Kind::NameOr(_, Kind::Object(_)) => text.trim_start().starts_with('{'),
            _ => self.is_document(),
        }
    }

    /// The JSON value that a text means. A text that is no such value stays text, for the reader to refuse;
    /// so does a document, which is read strictly later.
    pub fn value_of_text(&self, text: &str) -> Value {
        let as_text = || Value::String(text.to_owned());
        match self.kind {
            Kind::Whole { .. } | Kind::Number(_) | Kind::NameOr(_, Kind::Number(_)) => number(text)
                .or_else(|| serde_json::from_str(text).ok().filter(Value::is_array))
                .unwrap_or_else(as_text),
            Kind::Boolean => text.parse().map_or_else(|_| as_text(), Value::Bool),
            Kind::Component => text.parse::<u32>().map_or_else(|_| as_text(), Value::from),
            Kind::Vector(_) => vector(text).unwrap_or_else(as_text),
            _ => as_text(),
        }
    }
}

/// `x,y,z`, with or without brackets.
fn vector(text: &str) -> Option<Value> {
    let inner = text.trim();
    let brackets = inner
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'));
    let numbers = brackets.unwrap_or(inner).split(',').map(number);
    numbers.collect::<Option<Vec<_>>>().map(Value::Array)
}

/// The number that a text spells; whole numbers stay exact over the whole range of a seed.
fn number(text: &str) -> Option<Value> {
    let text = text.trim();
    let exact = text.parse::<u64>().map(Value::from).ok();
    exact.or_else(|| {
        let number = serde_json::Number::from_f64(text.parse().ok()?)?;
        Some(Value::Number(number))
    })
}

/// The object that form fields mean. Reports names that are given more than once, and stops at a document
/// that is no JSON.
pub fn object_of_form<'a>(
    settings: impl Iterator<Item = &'a Setting> + Clone,
    fields: impl IntoIterator<Item = (String, String)>,
    max_bytes: usize,
    faults: &mut Vec<FieldError>,
) -> Result<Map<String, Value>, FieldError> {
    let mut object = Map::new();
    for (name, text) in fields {
        let pointer = text::pointer(&name);
        let setting = settings.clone().find(|setting| setting.name == name);
        let value = match setting {
            Some(setting) if setting.reads_as_document(&text) => {
                json::read_up_to(text.as_bytes(), max_bytes)
                    .map_err(|problem| fault(&pointer, problem.detail))?
            }
            Some(setting) => setting.value_of_text(&text),
            None => Value::String(text),
        };
        if object.insert(name, value).is_some() {
            faults.push(fault(pointer, "given more than once; give it once"));
        }
    }
    Ok(object)
}
