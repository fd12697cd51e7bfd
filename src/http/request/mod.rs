//! Readers of requests: query, headers, bodies and forms.

pub mod accept;
pub mod body;
pub mod form;
pub mod idempotency;
pub mod json_body;
pub mod large;
pub mod lingering;
pub mod media_type;
pub mod query;
