//! Batches: many jobs submitted together.

use std::fmt;

use jiff::Timestamp;
use serde::{Serialize, Serializer};
use serde_json::value::RawValue;
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::settings::{LABEL, fault, refuse_unknown, value_of};
use super::{FieldError, JobId, JobState, PlanRequest, Problem};

/// Greatest number of jobs in a batch.
pub const MAX_BATCH_JOBS: usize = 10_000;
/// Greatest size of the request that submits a batch, in bytes.
pub const MAX_BATCH_BYTES: usize = 8 * 1024 * 1024;
/// Faults after which a request is read no further.
const MAX_FAULTS: usize = 20;

/// The id of a batch, of the same kind as that of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BatchId(JobId);

impl BatchId {
    /// Makes an id that sorts after all ids that this process made before.
    pub fn new() -> Self {
        Self(JobId::new())
    }

    /// Reads an id; `None` unless `text` has the form of one.
    pub fn parse(text: &str) -> Option<Self> {
        JobId::parse(text).map(Self)
    }
}

impl Default for BatchId {
    fn default() -> Self {
        Self::new()
    }
}

/// An idempotency key remembers a job or a batch by the same kind of id.
impl From<JobId> for BatchId {
    fn from(id: JobId) -> Self {
        Self(id)
    }
}

impl From<BatchId> for JobId {
    fn from(id: BatchId) -> Self {
        id.0
    }
}

impl fmt::Display for BatchId {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(out)
    }
}

impl Serialize for BatchId {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

/// The state of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum BatchState {
    /// Some of its jobs are queued or running.
    Running,
    /// None of its jobs will change any more.
    Ended,
}

/// The number of jobs of a batch in each state.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct JobCounts {
    /// Jobs that were submitted.
    pub total: u32,
    pub queued: u32,
    pub running: u32,
    pub succeeded: u32,
    pub failed: u32,
    pub cancelled: u32,
    /// Jobs that were deleted or have expired.
    pub forgotten: u32,
}

impl JobCounts {
    /// Counts `total` jobs; those that are in no state of `by_state` are forgotten.
    pub fn new(total: u32, by_state: impl IntoIterator<Item = (JobState, u32)>) -> Self {
        let mut counts = Self {
            total,
            forgotten: total,
            ..Self::default()
        };
        for (state, jobs) in by_state {
            counts.forgotten = counts.forgotten.saturating_sub(jobs);
            *match state {
                JobState::Queued => &mut counts.queued,
                JobState::Running => &mut counts.running,
                JobState::Succeeded => &mut counts.succeeded,
                JobState::Failed => &mut counts.failed,
                JobState::Cancelled => &mut counts.cancelled,
            } += jobs;
        }
        counts
    }

    /// Returns the state of a batch with these counts.
    pub fn state(&self) -> BatchState {
        match self.queued + self.running {
            0 => BatchState::Ended,
            _ => BatchState::Running,
        }
    }
}

/// A batch, as clients see it.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct BatchRecord {
    #[schema(value_type = String, format = "uuid")]
    pub id: BatchId,
    pub state: BatchState,
    /// The name that the client gave it.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    pub jobs: JobCounts,
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Timestamp,
    /// When the first of its remaining jobs started.
    #[schema(value_type = String, format = DateTime, nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub started_at: Option<Timestamp>,
    /// When the last of its jobs ended; present once the batch has ended.
    #[schema(value_type = String, format = DateTime, nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finished_at: Option<Timestamp>,
}

/// One page of batches, newest first.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct BatchPage {
    pub batches: Vec<BatchRecord>,
    /// Where the next page starts; absent on the last one.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

/// The outcome of one job of a batch: a line of its results.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct BatchResult {
    /// The position of the job in the batch, counted from 0.
    pub index: u32,
    #[schema(value_type = String, format = "uuid")]
    pub job_id: JobId,
    pub mesh_id: String,
    /// The name that the client gave the job.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    pub state: JobState,
    /// The result, byte for byte as the planner wrote it.
    #[schema(value_type = super::PlanResult, nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub result: Option<Box<RawValue>>,
    /// Why the job failed.
    #[schema(nullable = false)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<Problem>,
}

/// Jobs to be submitted together, all or none.
#[derive(Debug, Clone)]
pub struct BatchRequest {
    pub label: Option<String>,
    /// 1 to [`MAX_BATCH_JOBS`].
    pub jobs: Vec<BatchJob>,
    form: Form,
}

/// One of them.
#[derive(Debug, Clone)]
pub struct BatchJob {
    /// As its sender writes it.
    pub mesh_id: String,
    pub request: PlanRequest,
}

/// How its sender wrote the jobs of a batch down.
#[derive(Debug, Clone, Copy)]
enum Form {
    /// `meshes`, and one `request` for all.
    Meshes,
    /// `requests`, each with its mesh.
    Requests,
}

impl BatchRequest {
    /// Validates a JSON object, fills in the defaults, and reports the first fields at fault. `seed` gives the
    /// seed of the job at a place where the request has none.
    pub fn from_json(value: Value, seed: impl Fn(usize) -> u64) -> Result<Self, Vec<FieldError>> {
        let Value::Object(mut object) = value else {
            let detail = "the batch must be a JSON object";
            return Err(vec![fault("", detail)]);
        };
        let (meshes, requests) = (object.remove("meshes"), object.remove("requests"));
        let shared = object.remove("request");
        let mut faults = Vec::new();
        let accepted = "meshes, request, requests, label";
        refuse_unknown(&object, &["label"], accepted, "", &mut faults);
        let label = object.get("label");
        let label = label.and_then(|label| value_of(&LABEL.kind, label, "/label", &mut faults));
        let label = label.and_then(|label| label.as_str().map(str::to_owned));
        let (form, jobs) = match (meshes, requests) {
            (Some(meshes), None) => (Form::Meshes, on_meshes(meshes, shared, seed)),
            (None, Some(requests)) => {
                if shared.is_some() {
                    faults.push(fault(
                        "/request",
                        "goes with meshes; in requests each has settings of its own",
                    ));
                }
                (Form::Requests, of_requests(requests, seed))
            }
            _ => {
                let detail = "give either meshes, with one request for all, or requests";
                (Form::Meshes, Err(vec![fault("", detail)]))
            }
        };
        match jobs {
            Ok(jobs) if faults.is_empty() => Ok(Self { label, jobs, form }),
            jobs => {
                faults.extend(jobs.err().unwrap_or_default());
                Err(faults)
            }
        }
    }

    /// The pointer to the list of jobs.
    pub fn list_pointer(&self) -> &'static str {
        match self.form {
            Form::Meshes => "/meshes",
            Form::Requests => "/requests",
        }
    }

    /// The pointer to the mesh of the job at a place.
    pub fn mesh_pointer(&self, index: usize) -> String {
        match self.form {
            Form::Meshes => format!("/meshes/{index}"),
            Form::Requests => format!("/requests/{index}/mesh_id"),
        }
    }

    /// The pointer to the settings of the job at a place.
    pub fn settings_pointer(&self, index: usize) -> String {
        match self.form {
            Form::Meshes => "/request".to_owned(),
            Form::Requests => format!("/requests/{index}"),
        }
    }
}

/// The same settings on each of some meshes; only a seed that is not given differs.
fn on_meshes(
    meshes: Value,
    shared: Option<Value>,
    seed: impl Fn(usize) -> u64,
) -> Result<Vec<BatchJob>, Vec<FieldError>> {
    let mut faults = Vec::new();
    let shared = shared.unwrap_or_else(|| Value::Object(Map::new()));
    let has_seed = shared.get("seed").is_some();
    let request = settings(shared, seed(0))
        .map_err(|inner| faults.extend(within("/request", inner)))
        .ok();
    let mut ids = Vec::new();
    match list(meshes, "/meshes", "ids of meshes") {
        Err(wrong) => faults.push(wrong),
        Ok(items) => {
            for (index, item) in items.into_iter().enumerate() {
                match item {
                    Value::String(id) => ids.push(id),
                    _ => faults.push(fault(format!("/meshes/{index}"), MESH_ID)),
                }
                if faults.len() >= MAX_FAULTS {
                    break;
                }
            }
        }
    }
    let Some(request) = request.filter(|_| faults.is_empty()) else {
        return Err(faults);
    };
    let on = |(index, mesh_id)| {
        let mut request = request.clone();
        if !has_seed {
            request.seed = seed(index);
        }
        BatchJob { mesh_id, request }
    };
    Ok(ids.into_iter().enumerate().map(on).collect())
}

/// Each with its own mesh and settings.
fn of_requests(
    requests: Value,
    seed: impl Fn(usize) -> u64,
) -> Result<Vec<BatchJob>, Vec<FieldError>> {
    let items = list(requests, "/requests", "requests").map_err(|wrong| vec![wrong])?;
    let (mut jobs, mut faults) = (Vec::with_capacity(items.len()), Vec::new());
    for (index, mut item) in items.into_iter().enumerate() {
        let place = format!("/requests/{index}");
        let mesh_id = item
            .as_object_mut()
            .and_then(|object| object.remove("mesh_id"));
        let is_object = item.is_object();
        match (mesh_id, settings(item, seed(index))) {
            (Some(Value::String(mesh_id)), Ok(request)) => jobs.push(BatchJob { mesh_id, request }),
            (mesh_id, request) => {
                faults.extend(within(&place, request.err().unwrap_or_default()));
                if is_object && !matches!(mesh_id, Some(Value::String(_))) {
                    faults.push(fault(format!("{place}/mesh_id"), MESH_ID));
                }
            }
        }
        if faults.len() >= MAX_FAULTS {
            break;
        }
    }
    match faults.is_empty() {
        true => Ok(jobs),
        false => Err(faults),
    }
}

const MESH_ID: &str = "must be the id of an uploaded mesh";

/// Settings of a job that nobody waits for, unless they say otherwise.
fn settings(mut value: Value, seed: u64) -> Result<PlanRequest, Vec<FieldError>> {
    if let Value::Object(object) = &mut value {
        object.entry("priority").or_insert_with(|| "batch".into());
    }
    PlanRequest::from_json(&value, seed)
}

fn list(value: Value, pointer: &str, of: &str) -> Result<Vec<Value>, FieldError> {
    match value {
        Value::Array(items) if (1..=MAX_BATCH_JOBS).contains(&items.len()) => Ok(items),
        _ => {
            let detail = format!("must be a list of 1 to {MAX_BATCH_JOBS} {of}");
            Err(fault(pointer, detail))
        }
    }
}

/// Faults of a part as faults of the whole.
fn within(place: &str, faults: Vec<FieldError>) -> impl Iterator<Item = FieldError> {
    faults
        .into_iter()
        .map(move |inner| fault(format!("{place}{}", inner.pointer), inner.detail))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::wire::Priority;

    fn read(value: Value) -> Result<BatchRequest, Vec<FieldError>> {
        BatchRequest::from_json(value, |index| 100 + index as u64)
    }

    fn pointers(value: Value) -> Vec<String> {
        let faults = read(value).unwrap_err().into_iter();
        faults.map(|fault| fault.pointer).collect()
    }

    #[test]
    fn both_forms_mean_the_same_jobs() {
        let one = read(json!({"meshes": ["a", "b"], "request": {"contacts": 5}})).unwrap();
        let requests = json!([{"mesh_id": "a", "contacts": 5}, {"mesh_id": "b", "contacts": 5}]);
        let other = read(json!({"label": "x", "requests": requests})).unwrap();
        assert_eq!((one.label, other.label.as_deref()), (None, Some("x")));
        for (index, (one, other)) in one.jobs.iter().zip(&other.jobs).enumerate() {
            assert_eq!(
                (&one.mesh_id, &one.request),
                (&other.mesh_id, &other.request)
            );
            assert_eq!(
                (one.request.contacts, one.request.priority),
                (5, Priority::Batch)
            );
            assert_eq!(one.request.seed, 100 + index as u64);
        }
    }

    #[test]
    fn what_is_said_stays() {
        let request = json!({"seed": 7, "priority": "interactive"});
        let batch = read(json!({"meshes": ["a", "a"], "request": request})).unwrap();
        for job in batch.jobs {
            assert_eq!(
                (job.request.seed, job.request.priority),
                (7, Priority::Interactive)
            );
        }
    }

    #[test]
    fn faults_name_their_place() {
        assert_eq!(pointers(json!([])), [""]);
        assert_eq!(pointers(json!({})), [""]);
        assert_eq!(pointers(json!({"meshes": ["a"], "requests": []})), [""]);
        assert_eq!(pointers(json!({"meshes": []})), ["/meshes"]);
        assert_eq!(pointers(json!({"meshes": "a"})), ["/meshes"]);
        assert_eq!(
            pointers(json!({"requests": vec![json!({}); 10_001]})),
            ["/requests"]
        );
        assert_eq!(
            pointers(json!({"meshes": ["a", 1], "request": {"contacts": 0, "mesh_id": "a"}})),
            ["/request/mesh_id", "/request/contacts", "/meshes/1"]
        );
        assert_eq!(
            pointers(
                json!({"requests": [{"mesh_id": "a"}, {"contacts": 65}, 3], "x": 1, "label": 2})
            ),
            [
                "/x",
                "/label",
                "/requests/1/contacts",
                "/requests/1/mesh_id",
                "/requests/2"
            ]
        );
        assert_eq!(
            pointers(json!({"requests": [{"mesh_id": "a"}], "request": {}})),
            ["/request"]
        );
        assert_eq!(
            pointers(json!({"requests": vec![1; 10_000]})).len(),
            MAX_FAULTS
        );
    }
}
