//! Batches of jobs: submit, list, read, results, cancel, delete.

pub mod change;
pub mod read;
pub mod results;
pub mod submit;
