//! Records of jobs.

use std::fmt;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use jiff::Timestamp;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use serde_json::value::RawValue;
use utoipa::ToSchema;
use uuid::Uuid;

use super::{BatchId, CallbackRecord, Priority, Problem, Progress};

/// The id of a job: a UUID of version 7, so that ids sort by time of submission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct JobId(Uuid);

impl JobId {
    /// Makes an id that sorts after all ids that this process made before.
    pub fn new() -> Self {
        Self(Uuid::now_v7())
    }

    /// Returns the time since the id was made, to the millisecond; zero when the clock was set back.
    pub fn age(&self) -> Duration {
        let born = self.0.get_timestamp().map_or((0, 0), |time| time.to_unix());
        let born = UNIX_EPOCH + Duration::new(born.0, born.1);
        SystemTime::now().duration_since(born).unwrap_or_default()
    }

    /// Reads an id; `None` unless `text` is a UUID of version 7 in lower case with hyphens, so that every
    /// job has exactly one name.
    pub fn parse(text: &str) -> Option<Self> {
        let id = Uuid::try_parse(text).ok()?;
        (id.get_version_num() == 7 && id.to_string() == text).then_some(Self(id))
    }
}

impl Default for JobId {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Display for JobId {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(out)
    }
}

impl Serialize for JobId {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for JobId {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::parse(&text).ok_or_else(|| de::Error::custom("not the id of a job"))
    }
}

/// The state of a job: `queued → running → succeeded | failed | cancelled`, also
/// `queued → cancelled`, and `running → queued` when the server stops before the job ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

impl JobState {
    pub const ALL: [Self; 5] = [
        Self::Queued,
        Self::Running,
        Self::Succeeded,
        Self::Failed,
        Self::Cancelled,
    ];

    /// Returns the name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// Returns the state with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|state| state.name() == name)
    }

    /// Whether the job will not change any more.
    pub fn is_final(self) -> bool {
        match self {
            Self::Queued | Self::Running => false,
            Self::Succeeded | Self::Failed | Self::Cancelled => true,
        }
    }
}

/// A job, as clients see it.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct JobRecord {
    #[schema(value_type = String, format = "uuid")]
    pub id: JobId,
    /// The mesh to plan on; it may have been deleted once the job has ended.
    pub mesh_id: String,
    pub state: JobState,
    pub priority: Priority,
    /// The batch that the job belongs to.
    #[schema(value_type = String, format = "uuid", nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub batch_id: Option<BatchId>,
    /// Its position in the batch, counted from 0.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub batch_index: Option<u32>,
    /// The report on the mesh. Lists omit it, and it is deleted with the mesh.
    #[schema(value_type = graspd_core::mesh::MeshReport, nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh_report: Option<Box<RawValue>>,
    /// The name that the client gave it.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// The effective settings, with every default filled in and the seed fixed.
    #[schema(value_type = super::PlanRequest)]
    pub request: Box<RawValue>,
    /// The progress of the run; once the job has ended, the progress at its end.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub progress: Option<Progress>,
    /// The result, byte for byte as the planner wrote it. Lists omit it.
    #[schema(value_type = super::PlanResult, nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub result: Option<Box<RawValue>>,
    /// Why the job failed.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<Problem>,
    /// The delivery of the callback, if the job has one. Lists omit it.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub callback: Option<CallbackRecord>,
    /// 1, plus one for each time that the server stopped unexpectedly while the job ran.
    pub attempt: u32,
    /// Grows with every change of this record, except changes of `callback`.
    pub revision: u64,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Timestamp,
    /// When the last attempt started.
    #[schema(value_type = String, format = DateTime, nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub started_at: Option<Timestamp>,
    #[schema(value_type = String, format = DateTime, nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finished_at: Option<Timestamp>,
}

/// One page of jobs, newest first, without their results.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct JobPage {
    pub jobs: Vec<JobRecord>,
    /// Where the next page starts; absent on the last one.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}
