//! The JSON that enters and leaves, shared by the HTTP service, the store and the command line.

mod fields;
mod job;
pub mod json;
mod mesh;
mod problem;
mod progress;
mod read;
mod request;
mod result;
pub mod text;

pub use fields::{FIELDS, Field};
pub use job::{JobId, JobPage, JobRecord, JobState};
pub use mesh::{MassSource, MeshFormat, MeshId, MeshPage, MeshRecord, MeshReport};
pub use problem::{FieldError, Problem};
pub use progress::{Phase, Progress};
pub use request::{
    ContactModel, EdgeNorm, InitialMode, Method, PlanRequest, PlanRequestInput, TorqueScale, Units,
    random_seed,
};
pub use result::{
    ContactPoint, Explanation, HistoryEntry, InitialGrasp, PlanResult, Reason, StoppedBecause,
    TorqueScaleValue, WeakestWrench,
};
