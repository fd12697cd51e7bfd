//! What the rules between the members of an object see of it, and how they report faults.

use serde_json::{Map, Value};

use crate::wire::FieldError;

/// An object whose members have been read one by one, for the rules that concern several of them.
pub struct Checked<'a> {
    pub(super) given: &'a Map<String, Value>,
    /// The members that can be used, and the defaults of the others.
    pub read: Map<String, Value>,
    pub(super) place: &'a str,
    pub(super) faults: &'a mut Vec<FieldError>,
}

impl Checked<'_> {
    /// Whether a member was given, rightly or wrongly.
    pub fn is_given(&self, name: &str) -> bool {
        self.given.contains_key(name)
    }

    /// A member as it was given, whether or not it can be used.
    pub fn as_given(&self, name: &str) -> Option<&Value> {
        self.given.get(name)
    }

    /// A member that was given and can be used.
    pub fn given(&self, name: &str) -> Option<&Value> {
        self.read.get(name).filter(|_| self.is_given(name))
    }

    /// The number that a member is.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.read.get(name)?.as_f64()
    }

    /// The name that a member is.
    pub fn name(&self, name: &str) -> Option<&str> {
        self.read.get(name)?.as_str()
    }

    /// The values of a list.
    pub fn list(&self, name: &str) -> &[Value] {
        let list = self.read.get(name).and_then(Value::as_array);
        list.map_or(&[], Vec::as_slice)
    }

    /// Reports a member; `name` may go on to what is in it.
    pub fn fail(&mut self, name: &str, detail: impl Into<String>) {
        self.faults
            .push(fault(format!("{}/{name}", self.place), detail));
    }

    /// Reports one fault of a member, which replaces all faults reported about it and its contents.
    pub fn fail_alone(&mut self, name: &str, detail: impl Into<String>) {
        let pointer = format!("{}/{name}", self.place);
        self.faults
            .retain(|fault| !fault.pointer.starts_with(&pointer));
        self.faults.push(fault(pointer, detail));
    }
}

/// A fault at a place.
pub fn fault(pointer: impl Into<String>, detail: impl Into<String>) -> FieldError {
    FieldError {
        pointer: pointer.into(),
        detail: detail.into(),
    }
}
