//! The JSON that enters and leaves, shared by the HTTP service, the store and the command line.

mod problem;
mod progress;
mod request;
mod result;

pub use problem::{FieldError, Problem};
pub use progress::{Phase, Progress};
pub use request::PlanRequest;
pub use result::PlanResult;
