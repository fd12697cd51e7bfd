//! The exports of [`crate::export::EXPORTS`] as routes: each row of the table becomes one.

mod describe;
mod parameters;
mod serve;

pub use serve::routes;
