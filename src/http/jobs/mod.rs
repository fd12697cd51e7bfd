//! Planning jobs: submit, list, read, follow, cancel, delete.

pub mod change;
pub mod events;
pub mod job_result;
pub mod read;
pub mod submit;
