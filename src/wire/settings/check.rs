//! Reads JSON values by the definitions of settings, and collects every fault.
//!
//! The reader knows kinds and ranges, no request: what [`members`] returns is the object in its one form,
//! with defaults filled in and `8.0` written as `8`, which serde then turns into the type of the request.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::checked::{Checked, fault};
use super::definition::{Default, Kind, List, MAX_COORDINATE, MIN_DIRECTION, Setting, Vector};
use super::describe::{listed, words};
use crate::wire::{ContactSpec, FieldError, MAX_NAME_CHARS, text};

/// Faults of one list after which its other values are not looked at.
const MAX_FAULTS: usize = 20;

/// Reads the members of an object at `place` and fills in the defaults of those that are absent.
pub fn members<'a>(
    settings: impl Iterator<Item = &'a Setting> + Clone,
    rules: fn(&mut Checked<'_>),
    object: &Map<String, Value>,
    place: &str,
    faults: &mut Vec<FieldError>,
) -> Map<String, Value> {
    let names: Vec<&str> = settings.clone().map(|setting| setting.name).collect();
    refuse_unknown(object, &names, &names.join(", "), place, faults);
    let mut read = Map::new();
    for setting in settings.clone() {
        let pointer = format!("{place}{}", text::pointer(setting.name));
        match object.get(setting.name) {
            Some(value) => {
                let value = value_of(&setting.kind, value, &pointer, faults);
                read.extend(value.map(|value| (setting.name.to_owned(), value)));
            }
            None if matches!(setting.default, Default::Required) => {
                let detail = format!("is missing; it must be {}", words(&setting.kind));
                faults.push(fault(pointer, detail));
            }
            None => {}
        }
    }
    for setting in settings {
        if !read.contains_key(setting.name) {
            let default = match setting.default {
                Default::Required | Default::Absent(_) => None,
                Default::Value(json) => serde_json::from_str(json).ok(),
                Default::From { of, .. } => of(&read),
            };
            read.extend(default.map(|value| (setting.name.to_owned(), value)));
        }
    }
    let mut checked = Checked {
        given: object,
        read,
        place,
        faults,
    };
    rules(&mut checked);
    checked.read
}

/// The value of a type that members which were read make, if there was no fault.
pub fn typed<T: DeserializeOwned>(
    read: Map<String, Value>,
    mut faults: Vec<FieldError>,
) -> Result<T, Vec<FieldError>> {
    if faults.is_empty() {
        match serde_json::from_value(Value::Object(read)) {
            Ok(value) => return Ok(value),
            // The definition takes what the type does not; the tests look for that.
            Err(unfit) => faults.push(fault("", unfit.to_string())),
        }
    }
    Err(faults)
}

/// Reports the members that are not `known`; `accepted` may name more, which were taken out before.
pub fn refuse_unknown(
    object: &Map<String, Value>,
    known: &[&str],
    accepted: &str,
    place: &str,
    faults: &mut Vec<FieldError>,
) {
    let unknown = object.keys().filter(|name| !known.contains(&name.as_str()));
    for (index, name) in unknown.enumerate() {
        let detail = match index {
            0 => format!("unknown field; accepted are {accepted}"),
            // The list is long; once is enough.
            _ => "unknown field".to_owned(),
        };
        faults.push(fault(format!("{place}{}", text::pointer(name)), detail));
    }
}

/// The value in its one form, or nothing when it has a fault, which is reported at `place`.
pub fn value_of(
    kind: &Kind,
    value: &Value,
    place: &str,
    faults: &mut Vec<FieldError>,
) -> Option<Value> {
    let found = match kind {
        Kind::Whole { min, max, or_zero } => {
            let accepts = |n: &u64| (min..=max).contains(&n) || (*or_zero && *n == 0);
            whole(value).filter(accepts).map(Value::from)
        }
        Kind::Number(range) => value
            .as_f64()
            .filter(|x| range.contains(*x))
            .map(|_| value.clone()),
        Kind::Boolean => value.is_boolean().then(|| value.clone()),
        Kind::Choice(choice) => named(choice.names, value),
        Kind::NameOr(choice, other) => match (named(choice.names, value), other) {
            // The name alone stands for the object with it as the first member.
            (Some(name), Kind::Object(object)) => {
                let first = object.members.iter().map(|member| member.name.to_owned());
                let short =
                    Value::Object(first.take(1).map(|member| (member, name.clone())).collect());
                return value_of(other, &short, place, faults);
            }
            (Some(name), _) => Some(name),
            // The faults of an object say more.
            (None, Kind::Object(_)) if value.is_object() => {
                return value_of(other, value, place, faults);
            }
            (None, _) => value_of(other, value, place, &mut Vec::new()),
        },
        Kind::Text { max_chars } => fit_text(value, |text| text.chars().count() <= *max_chars),
        Kind::Url { max_bytes } => fit_text(value, |text| text.len() <= *max_bytes),
        Kind::Vector(vector) => return vector_of(kind, vector, value, place, faults),
        Kind::List(list) => return list_of(kind, list, value, place, faults),
        Kind::Object(object) => match value.as_object() {
            None => None,
            Some(given) => {
                let before = faults.len();
                let read = members(object.members.iter(), object.rules, given, place, faults);
                return (faults.len() == before).then_some(Value::Object(read));
            }
        },
        Kind::OneOf { members, .. } => {
            let mut given = value.as_object().into_iter().flatten();
            if let (Some((name, value)), None) = (given.next(), given.next()) {
                let place = format!("{place}{}", text::pointer(name));
                let Some(member) = members.iter().find(|member| member.name == name) else {
                    let names = listed(members.iter().map(|member| member.name.to_owned()));
                    faults.push(fault(place, format!("unknown field; use {names}")));
                    return None;
                };
                let value = value_of(&member.kind, value, &place, faults)?;
                return Some(Value::Object(Map::from_iter([(name.clone(), value)])));
            }
            None
        }
        Kind::Triangles { max } => return triangles(kind, *max, value, place, faults),
        Kind::Document => Some(Value::Null),
        Kind::Component => whole(value)
            .filter(|number| *number <= u64::from(u32::MAX))
            .map(Value::from)
            .or_else(|| {
                let lengths = 1..=MAX_NAME_CHARS;
                fit_text(value, |text| lengths.contains(&text.chars().count()))
            }),
        Kind::Contact => {
            return match ContactSpec::read(value) {
                Ok(contact) => serde_json::to_value(contact).ok(),
                Err((member, detail)) => {
                    faults.push(fault(format!("{place}{member}"), detail));
                    None
                }
            };
        }
    };
    if found.is_none() {
        faults.push(fault(place, format!("must be {}", words(kind))));
    }
    found
}

/// The whole number that a value is. JSON has one kind of number: 8.0 is the whole number 8. Past 2^53 that
/// would be a guess.
pub fn whole(value: &Value) -> Option<u64> {
    value.as_u64().or_else(|| {
        let x = value.as_f64()?;
        (x.fract() == 0.0 && (0.0..9_007_199_254_740_992.0).contains(&x)).then_some(x as u64)
    })
}

fn named(names: &[(&str, &str)], value: &Value) -> Option<Value> {
    let name = value.as_str()?;
    let is_known = names.iter().any(|(known, _)| *known == name);
    is_known.then(|| value.clone())
}

fn fit_text(value: &Value, is_short: impl Fn(&str) -> bool) -> Option<Value> {
    let text = value.as_str()?;
    let is_fit = is_short(text) && !text.chars().any(text::is_unsafe);
    is_fit.then(|| value.clone())
}

/// The numbers of a vector, where it has so many and each is within bounds.
pub fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let items = value.as_array().filter(|items| items.len() == N)?;
    let mut numbers = [0.0; N];
    for (number, item) in numbers.iter_mut().zip(items) {
        *number = coordinate(item)?;
    }
    Some(numbers)
}

/// Whether a vector is long enough to have a direction.
pub fn is_direction(vector: &[f64]) -> bool {
    let length = vector.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    length >= MIN_DIRECTION
}

fn coordinate(value: &Value) -> Option<f64> {
    value.as_f64().filter(|x| x.abs() <= MAX_COORDINATE)
}

fn vector_of(
    kind: &Kind,
    vector: &Vector,
    value: &Value,
    place: &str,
    faults: &mut Vec<FieldError>,
) -> Option<Value> {
    let items = value
        .as_array()
        .filter(|items| items.len() == vector.length);
    let before = faults.len();
    let mut numbers = Vec::with_capacity(vector.length);
    let mut is_fit = items.is_some();
    for (index, item) in items.into_iter().flatten().enumerate() {
        match coordinate(item) {
            Some(x) => numbers.push(x),
            None if vector.faults_by_component => {
                let detail = "must be a number from -1e12 to 1e12";
                faults.push(fault(format!("{place}/{index}"), detail));
            }
            None => is_fit = false,
        }
    }
    if faults.len() > before {
        return None;
    }
    if !is_fit || (vector.is_direction && !is_direction(&numbers)) {
        faults.push(fault(place, format!("must be {}", words(kind))));
        return None;
    }
    Some(value.clone())
}

fn list_of(
    kind: &Kind,
    list: &List,
    value: &Value,
    place: &str,
    faults: &mut Vec<FieldError>,
) -> Option<Value> {
    let is_fit = |items: &&Vec<Value>| (list.min..=list.max).contains(&items.len());
    let Some(items) = value.as_array().filter(is_fit) else {
        faults.push(fault(place, format!("must be {}", words(kind))));
        return None;
    };
    let before = faults.len();
    let mut read = Vec::with_capacity(items.len());
    for (index, item) in items.iter().enumerate() {
        read.extend(value_of(list.of, item, &format!("{place}/{index}"), faults));
        if faults.len() - before >= MAX_FAULTS {
            break;
        }
    }
    (faults.len() == before).then_some(Value::Array(read))
}

fn triangles(
    kind: &Kind,
    max: usize,
    value: &Value,
    place: &str,
    faults: &mut Vec<FieldError>,
) -> Option<Value> {
    let Some(items) = value.as_array().filter(|items| items.len() <= max) else {
        faults.push(fault(place, format!("must be {}", words(kind))));
        return None;
    };
    let is_index = |item: &Value| item.as_u64().is_some_and(|n| u32::try_from(n).is_ok());
    if let Some(index) = items.iter().position(|item| !is_index(item)) {
        // One is enough where the list is long.
        let detail = "must be the number of a triangle, counted from 0";
        faults.push(fault(format!("{place}/{index}"), detail));
        return None;
    }
    Some(value.clone())
}
