//! Rows as both databases return them, and the records that they stand for.

use std::collections::HashMap;

use jiff::Timestamp;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::value::RawValue;
use sqlx::FromRow;

use crate::store::{KeyRecord, MeshSummary, StoreError, damaged, timestamp};
use crate::wire::{
    BatchId, BatchRecord, BatchResult, BatchState, CallbackRecord, CallbackState, JobCounts, JobId,
    JobRecord, JobState, MeshId, MeshRecord, Priority, Units,
};
use graspd_mesh_io::MeshFormat;

/// Results of more bytes are read off the async threads.
const LONG_RESULT: usize = 64 * 1024;

/// Every column of a [`JobRecord`] but the result, which may be long.
macro_rules! job_columns {
    () => {
        "id, mesh_id, state, priority, attempt, revision, created_at, started_at, finished_at, \
         label, request, progress, problem, batch_id, batch_index"
    };
}
pub(in crate::store) use job_columns;

/// The same with the report of the job's mesh.
macro_rules! job_columns_with_mesh {
    () => {
        concat!(
            crate::store::common::rows::job_columns!(),
            ", (SELECT report FROM meshes WHERE meshes.owner = jobs.owner AND meshes.id = jobs.mesh_id) \
             AS mesh_report"
        )
    };
}
pub(in crate::store) use job_columns_with_mesh;

/// Every column of a [`MeshRecord`].
macro_rules! mesh_columns {
    () => {
        "seq, id, format, units, scale, bytes, file_name, created_at, report"
    };
}
pub(in crate::store) use mesh_columns;

/// A row of [`job_columns`] or of [`job_columns_with_mesh`].
#[derive(FromRow)]
pub struct JobRow {
    id: String,
    mesh_id: String,
    #[sqlx(default)]
    mesh_report: Option<String>,
    state: String,
    priority: String,
    attempt: i64,
    revision: i64,
    created_at: i64,
    started_at: Option<i64>,
    finished_at: Option<i64>,
    label: Option<String>,
    request: String,
    progress: Option<String>,
    problem: Option<String>,
    batch_id: Option<String>,
    batch_index: Option<i64>,
}

impl TryFrom<JobRow> for JobRecord {
    type Error = StoreError;

    /// A record without its result.
    fn try_from(row: JobRow) -> Result<Self, StoreError> {
        Ok(Self {
            id: job_id(&row.id)?,
            mesh_id: row.mesh_id,
            mesh_report: row
                .mesh_report
                .map(RawValue::from_string)
                .transpose()
                .map_err(damaged)?,
            state: job_state(&row.state)?,
            priority: Priority::named(&row.priority).ok_or_else(|| damaged("job priority"))?,
            batch_id: row.batch_id.as_deref().map(batch_id).transpose()?,
            batch_index: row.batch_index.map(count).transpose()?,
            label: row.label,
            request: RawValue::from_string(row.request).map_err(damaged)?,
            progress: parsed(row.progress)?,
            result: None,
            problem: parsed(row.problem)?,
            callback: None,
            attempt: count(row.attempt)?,
            revision: row.revision as u64,
            created_at: timestamp(row.created_at)?,
            started_at: row.started_at.map(timestamp).transpose()?,
            finished_at: row.finished_at.map(timestamp).transpose()?,
        })
    }
}

/// A row of [`mesh_columns`].
#[derive(FromRow)]
pub struct MeshRow {
    /// Order of arrival.
    pub seq: i64,
    id: String,
    format: String,
    units: Option<String>,
    scale: f64,
    bytes: i64,
    file_name: Option<String>,
    created_at: i64,
    report: String,
}

impl TryFrom<MeshRow> for MeshRecord {
    type Error = StoreError;

    fn try_from(row: MeshRow) -> Result<Self, StoreError> {
        Ok(Self {
            id: mesh_id(&row.id)?,
            format: MeshFormat::from_name(&row.format).ok_or_else(|| damaged("mesh format"))?,
            units: units(row.units.as_deref())?,
            scale: row.scale,
            bytes: row.bytes as u64,
            file_name: row.file_name,
            created_at: timestamp(row.created_at)?,
            report: RawValue::from_string(row.report).map_err(damaged)?,
        })
    }
}

/// A row of [`MeshSummary`].
#[derive(FromRow)]
pub struct MeshSummaryRow {
    pub id: String,
    candidates: i64,
    report: String,
    units: Option<String>,
    used_at: i64,
}

/// What a summary takes from a report; reports of earlier versions do not have it.
#[derive(Deserialize)]
struct Bodies {
    #[serde(default)]
    body_count: u64,
}

impl TryFrom<MeshSummaryRow> for MeshSummary {
    type Error = StoreError;

    fn try_from(row: MeshSummaryRow) -> Result<Self, StoreError> {
        Ok(Self {
            candidates: row.candidates as u64,
            bodies: serde_json::from_str::<Bodies>(&row.report)
                .map_err(damaged)?
                .body_count,
            units: units(row.units.as_deref())?,
            used_at: row.used_at,
        })
    }
}

/// A key without its hash.
#[derive(FromRow)]
pub struct KeyRow {
    id: String,
    name: String,
    created_at: i64,
    expires_at: Option<i64>,
    revoked_at: Option<i64>,
}

impl TryFrom<KeyRow> for KeyRecord {
    type Error = StoreError;

    fn try_from(row: KeyRow) -> Result<Self, StoreError> {
        Ok(Self {
            id: row.id,
            name: row.name,
            created_at: timestamp(row.created_at)?,
            expires_at: row.expires_at.map(timestamp).transpose()?,
            revoked_at: row.revoked_at.map(timestamp).transpose()?,
        })
    }
}

/// A row of [`CallbackRecord`].
#[derive(FromRow)]
pub struct CallbackRow {
    callback_url: String,
    callback_state: String,
    attempts: i64,
    last_error: Option<String>,
    last_attempt_at: Option<i64>,
    due_at: Option<i64>,
}

impl TryFrom<CallbackRow> for CallbackRecord {
    type Error = StoreError;

    fn try_from(row: CallbackRow) -> Result<Self, StoreError> {
        let at = |time: Option<i64>| -> Result<Option<Timestamp>, StoreError> {
            time.map(timestamp).transpose()
        };
        Ok(Self {
            url: row.callback_url,
            state: CallbackState::named(&row.callback_state)
                .ok_or_else(|| damaged("callback state"))?,
            attempts: count(row.attempts)?,
            last_error: row.last_error,
            last_attempt_at: at(row.last_attempt_at)?,
            next_attempt_at: at(row.due_at)?,
        })
    }
}

/// A batch without its progress.
#[derive(FromRow)]
pub struct BatchRow {
    pub id: String,
    label: Option<String>,
    jobs: i64,
    created_at: i64,
}

/// How many jobs of a batch are in one state, when the first began and when the last ended.
#[derive(FromRow)]
pub struct ProgressRow {
    batch_id: String,
    state: String,
    jobs: i64,
    started_at: Option<i64>,
    finished_at: Option<i64>,
}

/// Returns the records of batches in their order, each with its own rows of `progress`.
pub fn batches(
    batches: Vec<BatchRow>,
    progress: &[ProgressRow],
) -> Result<Vec<BatchRecord>, StoreError> {
    let mut of: HashMap<&str, Vec<&ProgressRow>> = HashMap::new();
    for row in progress {
        of.entry(&row.batch_id).or_default().push(row);
    }
    let record = |batch: BatchRow| {
        let rows = of.get(batch.id.as_str()).map_or(&[][..], Vec::as_slice);
        let in_state = |row: &&ProgressRow| {
            let state = job_state(&row.state)?;
            Ok((state, count(row.jobs)?))
        };
        let counts: Vec<_> = rows
            .iter()
            .map(in_state)
            .collect::<Result<_, StoreError>>()?;
        let jobs = JobCounts::new(count(batch.jobs)?, counts);
        let state = jobs.state();
        let started = rows.iter().filter_map(|row| row.started_at).min();
        let finished = rows.iter().filter_map(|row| row.finished_at).max();
        Ok(BatchRecord {
            id: batch_id(&batch.id)?,
            state,
            label: batch.label,
            jobs,
            created_at: timestamp(batch.created_at)?,
            started_at: started.map(timestamp).transpose()?,
            finished_at: finished
                .filter(|_| state == BatchState::Ended)
                .map(timestamp)
                .transpose()?,
        })
    };
    batches.into_iter().map(record).collect()
}

/// A row of [`BatchResult`].
#[derive(FromRow)]
pub struct BatchResultRow {
    id: String,
    batch_index: i64,
    mesh_id: String,
    label: Option<String>,
    state: String,
    problem: Option<String>,
    result: Option<String>,
}

impl BatchResultRow {
    pub async fn into_result(self) -> Result<BatchResult, StoreError> {
        let result = match self.result {
            Some(text) => Some(result(text).await?),
            None => None,
        };
        Ok(BatchResult {
            index: count(self.batch_index)?,
            job_id: job_id(&self.id)?,
            mesh_id: self.mesh_id,
            label: self.label,
            state: job_state(&self.state)?,
            result,
            problem: parsed(self.problem)?,
        })
    }
}

pub fn batch_id(text: &str) -> Result<BatchId, StoreError> {
    BatchId::parse(text).ok_or_else(|| damaged("batch id"))
}

pub fn job_id(text: &str) -> Result<JobId, StoreError> {
    JobId::parse(text).ok_or_else(|| damaged("job id"))
}

pub fn mesh_id(text: &str) -> Result<MeshId, StoreError> {
    MeshId::parse(text).ok_or_else(|| damaged("mesh id"))
}

/// Returns the id of a job with its revision.
pub fn job_and_revision((id, revision): &(String, i64)) -> Result<(JobId, u64), StoreError> {
    Ok((job_id(id)?, *revision as u64))
}

/// A number that the database has 64 bits for and the service 32.
pub fn count(number: i64) -> Result<u32, StoreError> {
    u32::try_from(number).map_err(damaged)
}

pub fn job_state(name: &str) -> Result<JobState, StoreError> {
    JobState::named(name).ok_or_else(|| damaged("job state"))
}

pub fn units(name: Option<&str>) -> Result<Option<Units>, StoreError> {
    let named = |name| Units::named(name).ok_or_else(|| damaged("mesh units"));
    name.map(named).transpose()
}

/// Checks a stored result, which takes long for a long one.
pub async fn result(text: String) -> Result<Box<RawValue>, StoreError> {
    if text.len() <= LONG_RESULT {
        return RawValue::from_string(text).map_err(damaged);
    }
    let checked = tokio::task::spawn_blocking(|| RawValue::from_string(text));
    checked.await.map_err(damaged)?.map_err(damaged)
}

fn parsed<T: DeserializeOwned>(text: Option<String>) -> Result<Option<T>, StoreError> {
    text.map(|text| serde_json::from_str(&text))
        .transpose()
        .map_err(damaged)
}
