//! The settings of requests: defined once, read, described and documented from there.

#[cfg(test)]
mod analysis_tests;
mod check;
mod definition;
mod describe;
pub mod reference;
pub mod rules;
pub mod schema;
mod table;
#[cfg(test)]
mod tests;
mod text;

pub use check::{
    Checked, fault, is_direction, members, numbers, refuse_unknown, typed, value_of, whole,
};
pub use definition::{Kind, Scope, Setting};
pub use describe::{flag_help, words};
pub use rules::UNIFORM_COUNT;
pub use table::{FILE_SETTINGS, LABEL, MAX_CONTACTS, SETTINGS};
pub use text::{MAX_DOCUMENT_BYTES, object_of_form};
