//! The settings of requests: defined once, read, described and documented from there.

#[cfg(test)]
mod analysis_tests;
mod check;
mod checked;
mod definition;
mod describe;
mod objects;
pub mod reference;
pub mod rules;
pub mod schema;
mod table;
#[cfg(test)]
mod tests;
mod text;

pub use check::{is_direction, members, numbers, refuse_unknown, typed, value_of, whole};
pub use checked::{Checked, fault};
pub use definition::{Kind, MAX_CONTACTS, Scope, Setting};
pub use describe::{flag_help, words};
pub use rules::UNIFORM_COUNT;
pub use table::{FILE_SETTINGS, LABEL, SETTINGS};
pub use text::{MAX_DOCUMENT_BYTES, object_of_form};
