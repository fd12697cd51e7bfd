//! Strict JSON: what two readers could understand differently is refused.

use std::cell::RefCell;
use std::fmt;

use serde::de::{self, DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

use super::{FieldError, Problem, text};

/// Most bytes of a JSON document.
pub const MAX_JSON_BYTES: usize = 64 * 1024;

/// Reads one JSON document and nothing behind it.
///
/// Refuses with 413 what is too long, and with 400 invalid UTF-8, an empty or truncated
/// document, duplicate keys, nesting deeper than serde_json's 127 levels and trailing garbage.
pub fn read(bytes: &[u8]) -> Result<Value, Problem> {
    read_up_to(bytes, MAX_JSON_BYTES)
}

/// As [`read`], with a limit of its own.
pub fn read_up_to(bytes: &[u8], limit: usize) -> Result<Value, Problem> {
    if bytes.len() > limit {
        return Err(too_large(limit));
    }
    let text = std::str::from_utf8(bytes).map_err(|fault| {
        malformed(format!(
            "the JSON is not valid UTF-8 at byte {}",
            fault.valid_up_to()
        ))
    })?;
    if text.trim().is_empty() {
        return Err(malformed("the JSON document is empty".to_owned()));
    }
    let duplicate = RefCell::new(None);
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let root = Strict {
        pointer: String::new(),
        duplicate: &duplicate,
    };
    root.deserialize(&mut deserializer)
        .and_then(|value| deserializer.end().map(|()| value))
        .map_err(|fault| match duplicate.take() {
            Some(pointer) => malformed("a key appears twice in one JSON object".to_owned())
                .with_errors(vec![FieldError {
                    pointer,
                    detail: "given more than once; give it once".to_owned(),
                }]),
            None => malformed(format!("the JSON cannot be read: {fault}")),
        })
}

/// The answer to a JSON document of more than `limit` bytes.
pub fn too_large(limit: usize) -> Problem {
    Problem::new(
        413,
        "too-large",
        "Content too large",
        format!("this JSON document may have at most {limit} bytes"),
    )
}

fn malformed(detail: String) -> Problem {
    Problem::new(400, "malformed-json", "Malformed JSON", detail)
}

/// Builds a [`Value`] and leaves the pointer of a duplicate key in `duplicate`.
struct Strict<'a> {
    pointer: String,
    duplicate: &'a RefCell<Option<String>>,
}

impl Strict<'_> {
    fn child(&self, segment: &str) -> Self {
        Self {
            pointer: format!("{}{}", self.pointer, text::pointer(segment)),
            ..*self
        }
    }
}

impl<'de> DeserializeSeed<'de> for Strict<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Strict<'_> {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E: de::Error>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E: de::Error>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<Value, E> {
        Ok(Value::from(value))
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Value, E> {
        Number::from_f64(value)
            .map(Value::Number)
            .ok_or_else(|| E::custom("number out of range"))
    }

    fn visit_str<E: de::Error>(self, value: &str) -> Result<Value, E> {
        Ok(Value::String(value.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut array = Vec::new();
        while let Some(item) = items.next_element_seed(self.child(&array.len().to_string()))? {
            array.push(item);
        }
        Ok(Value::Array(array))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            let child = self.child(&key);
            if object.contains_key(&key) {
                *self.duplicate.borrow_mut() = Some(child.pointer);
                return Err(de::Error::custom("duplicate key"));
            }
            object.insert(key, entries.next_value_seed(child)?);
        }
        Ok(Value::Object(object))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sound_document_reads_as_serde_json_reads_it() {
        let text = r#"{"a": [1, -2, 0.1, true, null, "\u00e9"], "s": 18446744073709551615}"#;
        let expected: Value = serde_json::from_str(text).unwrap();
        assert_eq!(read(text.as_bytes()).unwrap(), expected);
    }

    #[test]
    fn faulty_documents_are_refused() {
        let deep = "[".repeat(129) + &"]".repeat(129);
        for bytes in [
            &b""[..],
            b"  ",
            b"{",
            b"{} x",
            b"[1,]",
            b"\"\xff\"",
            b"NaN",
            b"{\"a\":1e999}",
            deep.as_bytes(),
        ] {
            assert_eq!(read(bytes).unwrap_err().status, 400, "{bytes:?}");
        }
        let long = vec![b' '; MAX_JSON_BYTES + 1];
        assert_eq!(read(&long).unwrap_err().status, 413);
    }

    #[test]
    fn a_duplicate_key_is_refused_with_its_pointer() {
        let problem = read(br#"{"a": [{"x/y": 1, "x/y": 2}]}"#).unwrap_err();
        assert_eq!(
            (problem.status, problem.errors[0].pointer.as_str()),
            (400, "/a/0/x~1y")
        );
    }
}
