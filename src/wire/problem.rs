//! RFC 9457 problem details.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Greatest number of fields that one problem names.
const MAX_ERRORS: usize = 20;

/// Why a request or a job failed, and what to do about it (`application/problem+json`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Problem {
    /// Stable name of the kind of problem, a URI reference such as `/problems/invalid-request`.
    #[serde(rename = "type")]
    pub kind: String,
    /// The kind in a few words.
    pub title: String,
    /// HTTP status code.
    pub status: u16,
    /// The fault in this case and what to do about it.
    pub detail: String,
    /// The first 20 fields at fault, when fields are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<FieldError>,
}

/// One field at fault.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FieldError {
    /// JSON pointer (RFC 6901) to the field in the request; for a form, `/field-name`.
    pub pointer: String,
    /// The fault of the field and what is accepted.
    pub detail: String,
}

impl Problem {
    /// Makes a problem; `kind` is the last segment of its type, such as `invalid-request`.
    pub fn new(status: u16, kind: &str, title: &str, detail: impl Into<String>) -> Self {
        Self {
            kind: format!("/problems/{kind}"),
            title: title.to_owned(),
            status,
            detail: detail.into(),
            errors: Vec::new(),
        }
    }

    /// 422: fields are unknown, of the wrong type, out of range or at odds with each other.
    pub fn invalid(errors: Vec<FieldError>) -> Self {
        Self::new(
            422,
            "invalid-request",
            "Invalid request",
            "some fields cannot be used; see errors",
        )
        .with_errors(errors)
    }

    /// Names the first twenty of the fields at fault.
    pub fn with_errors(mut self, mut errors: Vec<FieldError>) -> Self {
        errors.truncate(MAX_ERRORS);
        self.errors = errors;
        self
    }
}
