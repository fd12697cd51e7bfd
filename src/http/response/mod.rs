//! Responses: JSON, files, and the problems that refusals are.

pub mod conditional;
pub mod error;
pub mod framework;
pub mod json;
mod service_errors;
mod status_problem;
