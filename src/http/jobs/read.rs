//! Lists jobs, and reads one and its result.

use std::time::Duration;

use axum::extract::State;
use axum::http::header::IF_NONE_MATCH;
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::request::query::{
    CURSOR, DEFAULT_LIMIT, LIMIT, Name, Param, STATE, WaitQuery, query, text,
};
use crate::http::response::conditional;
use crate::http::response::error::Error;
use crate::http::response::json::{self, POLL_S};
use crate::jobs::JobFilter;
use crate::wire::{JobPage, JobRecord, JobState, PlanResult};

const MESH_ID: Param<String> = Param {
    name: "mesh_id",
    description: "Only jobs on this mesh",
    expected: "the id of a mesh",
    parse: |text| Some(text.to_owned()),
    schema: text,
};

const BATCH_ID: Param<String> = Param {
    name: "batch_id",
    description: "Only jobs of this batch",
    expected: "the id of a batch",
    parse: |text| Some(text.to_owned()),
    schema: text,
};

query! {
    /// Which jobs to list.
    pub struct JobsQuery {
        state: JobState = STATE,
        mesh_id: String = MESH_ID,
        batch_id: String = BATCH_ID,
        limit: u32 = LIMIT,
        cursor: String = CURSOR,
    }
}

/// List jobs, newest first
#[utoipa::path(
    get, path = "/jobs", params(JobsQuery),
    responses((status = 200, description = "One page", body = JobPage)),
)]
pub async fn list_jobs(
    State(app): State<App>,
    Caller(owner): Caller,
    query: JobsQuery,
) -> Result<Response, Error> {
    let filter = JobFilter {
        owner,
        state: query.state,
        mesh_id: query.mesh_id,
        batch_id: query.batch_id,
    };
    let limit = query.limit.unwrap_or(DEFAULT_LIMIT);
    let page = app.service.jobs(&filter, limit, query.cursor.as_deref());
    json::json(StatusCode::OK, &page.await?)
}

/// Read a job: state, progress, effective settings
///
/// With `wait` the answer comes once the job has ended, or when the time is over, with the job as it is. With `wait`,
/// `If-None-Match` and the entity tag of the job the answer comes once anything about the job has changed, its progress
/// included, or when the time is over, with 304. A server that shuts down answers at once.
#[utoipa::path(
    get, path = "/jobs/{id}",
    params(
        WaitQuery,
        ("If-None-Match" = Option<String>, Header, description = "The ETag of the job as the client has it"),
    ),
    responses((status = 200, description = "The job", body = JobRecord, headers(
        ("ETag" = String, description = "Changes with the job; weak while the job is unfinished, since the time in its progress goes on"),
        ("Retry-After" = u64, description = "While the job is unfinished: seconds until it is worth a look")))),
)]
pub async fn read_job(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: WaitQuery,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let is_conditional = headers.contains_key(IF_NONE_MATCH);
    let is_news = |job: &JobRecord| {
        job.state.is_final() || (is_conditional && !conditional::has(&headers, &record_tag(job)))
    };
    let wait = query.wait.unwrap_or(Duration::ZERO);
    let job = app.service.wait_for_job(&owner, &id, wait, is_news).await?;
    let tag = record_tag(&job);
    if conditional::has(&headers, &tag) {
        return Ok(conditional::not_modified(&tag));
    }
    if job.state.is_final() {
        // Waiting returned the job without its result.
        return conditional::tagged_json(&headers, &tag, &app.service.job(&owner, &id).await?);
    }
    let mut response = conditional::tagged_json(&headers, &tag, &job)?;
    json::set_retry_after(&mut response);
    Ok(response)
}

/// Read the result of a job
///
/// 409 until there is one: with Retry-After while the job is queued or running, without when it failed (the problem says
/// why) or was cancelled before anything was found.
#[utoipa::path(
    get, path = "/jobs/{id}/result", params(WaitQuery),
    responses(
        (status = 200, description = "The result", body = PlanResult, headers(("ETag" = String, description = "Names these bytes"))),
        (status = 409, description = "No result yet, or the job ended without one", headers(
            ("Retry-After" = u64, description = "While the job is unfinished: seconds until it is worth a look"))),
    ),
)]
pub async fn read_result(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: WaitQuery,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let has_ended = |job: &JobRecord| job.state.is_final();
    let wait = query.wait.unwrap_or(Duration::ZERO);
    let job = app
        .service
        .wait_for_job(&owner, &id, wait, has_ended)
        .await?;
    if !has_ended(&job) {
        return Err(Error::conflict("this job has not ended yet").retry_after(POLL_S));
    }
    let tag = tag(&job, "result");
    // A job that has succeeded certainly has a result; for any other the result has to be read first.
    if job.state == JobState::Succeeded && conditional::has(&headers, &tag) {
        return Ok(conditional::not_modified(&tag));
    }
    if let Some(result) = app.service.result(&owner, &id).await? {
        return conditional::tagged_json(&headers, &tag, &result);
    }
    let why = job.problem.map_or_else(
        || "it was cancelled before anything was found".to_owned(),
        |problem| format!("it failed: {}: {}", problem.title, problem.detail),
    );
    Err(Error::conflict(format!("this job has no result; {why}")))
}

/// The entity tag of a job or of its result, known without the bytes. Neither changes after the end. Before
/// it, the record changes with its revision, except for the time in its progress.
fn tag(job: &JobRecord, part: &str) -> String {
    let weak = if job.state.is_final() { "" } else { "W/" };
    format!("{weak}\"{}-{}-{part}\"", job.id, job.revision)
}

/// The entity tag of a record. Its callback changes after the end too.
fn record_tag(job: &JobRecord) -> String {
    match &job.callback {
        None => tag(job, "job"),
        Some(callback) => {
            let part = format!("job-{}-{}", callback.state.name(), callback.attempts);
            tag(job, &part)
        }
    }
}
