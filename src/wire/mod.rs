//! The JSON that enters and leaves, shared by the HTTP service, the store and the command line: requests, and
//! the envelopes of what the service keeps and answers. Plain data of the planner, such as measures, robustness
//! or the report of a mesh, is `graspd-core`'s and is written as it is.

mod batch;
mod callback;
mod candidates;
mod chosen;
mod constraints;
mod contact;
mod evaluation;
mod job;
pub mod json;
mod mesh;
mod priority;
mod problem;
mod progress;
mod region;
mod request;
mod result;
pub mod settings;
mod surface;
pub mod text;
mod trials;

pub use batch::{
    BatchId, BatchJob, BatchPage, BatchRecord, BatchRequest, BatchResult, BatchState, JobCounts,
    MAX_BATCH_BYTES, MAX_BATCH_JOBS,
};
pub use callback::{CallbackRecord, CallbackState, MAX_URL_BYTES, WebhookEvent};
pub use candidates::{CandidateKind, SearchedCandidates};
pub use chosen::{Chosen, ChosenGrasp};
pub use constraints::Constraints;
pub use contact::ContactSpec;
pub use evaluation::{
    EvaluatedContact, EvaluationRequest, Evaluations, ExplainedObstacle, GraspEvaluation,
    MAX_EVALUATION_BYTES, MAX_GRASPS, ObstacleReason, Resistance,
};
pub use job::{JobId, JobPage, JobRecord, JobState};
pub use mesh::{MeshId, MeshOptions, MeshPage, MeshRecord};
pub use priority::Priority;
pub use problem::{FieldError, Problem};
pub use progress::{JobProgress, Progress};
pub use region::{Corners, HalfSpace, Region, Sphere};
pub use request::{
    PlanRequest, PlanRequestInput, QualitySettings, TorqueScaleSchema, Units, random_seed,
};
pub use result::{
    ContactPoint, Explanation, HistoryEntry, InitialGrasp, PlanResult, Reason, TopGrasp,
    TorqueScaleValue, WeakestWrench,
};
pub use surface::{Component, MAX_NAME_CHARS, SurfaceSettings};
pub use trials::{Statistics, Trial, Trials};
