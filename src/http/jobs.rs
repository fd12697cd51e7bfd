//! Jobs: submit, list, read, cancel, forget.

use axum::extract::{Request, State};
use axum::http::header::{IF_NONE_MATCH, RETRY_AFTER};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde_json::Value;

use super::access::Caller;
use super::error::Error;
use super::form::{self, Form, MeshFile};
use super::openapi::{JobForm, JobRequest};
use super::query::{Name, Parameters};
use super::reply::POLL_S;
use super::{App, body, once, reply};
use crate::jobs::{IdempotencyKey, JobFilter, MeshUpload, Owner};
use crate::wire::json::MAX_JSON_BYTES;
use crate::wire::{
    FieldError, JobPage, JobRecord, JobState, MeshOptions, PlanRequest, PlanResult, random_seed,
};

/// Plan a grasp
///
/// As a multipart form with the mesh file in the part `mesh` and each setting as a simple field
/// (or all of them as JSON in one part `request`), or as JSON with the `mesh_id` of an uploaded
/// mesh. The answer comes once job and mesh are safely stored.
#[utoipa::path(
    post, path = "/jobs",
    operation_id = "submit_job", tag = "jobs",
    params(("Idempotency-Key" = Option<String>, Header, min_length = 1, max_length = 255, description = "A key of the client's choice, such as a UUID: in the next 24 hours the same request under the same key makes no second job but answers the first")),
    request_body(content((JobForm = "multipart/form-data"), (JobRequest = "application/json"))),
    responses(
        (status = 202, description = "Accepted", body = JobRecord, headers(
            ("Location" = String, description = "Where the job is"),
            ("Retry-After" = u64, description = "Seconds until it is worth a look"))),
        (status = 400, description = "Malformed JSON or form, no file, two files"),
        (status = 406, description = "JSON is not accepted"),
        (status = 408, description = "The body came too slowly"),
        (status = 409, description = "A submission under the same Idempotency-Key is under way"),
        (status = 410, description = "The job of this Idempotency-Key has been deleted"),
        (status = 413, description = "Larger than the server takes"),
        (status = 415, description = "Neither form nor JSON, or no mesh in a supported format"),
        (status = 422, description = "Settings or a mesh that cannot be used, an unknown mesh_id, a callback_url that is not allowed, or an Idempotency-Key that another request was sent under; errors say which"),
        (status = 503, description = "The queue is full, or the server is shutting down"),
        (status = 507, description = "The disk of the server is full"),
    ),
)]
pub async fn submit(
    State(app): State<App>,
    Caller(owner): Caller,
    query: Parameters,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Error> {
    query.only(&[])?;
    let key = once::begin(&app.service, &owner, &headers)?;
    let job = match body::media_type(&headers)?.as_deref() {
        Some("multipart/form-data") => {
            let form = form::read(&app, request, MAX_JSON_BYTES).await?;
            from_form(&app, &owner, form, key).await?
        }
        Some("application/json") => {
            let body = body::read_json(request, MAX_JSON_BYTES).await?;
            from_json(&app, &owner, body, key).await?
        }
        _ => {
            return Err(Error::unsupported(
                "send multipart/form-data with the mesh file, or application/json with mesh_id",
            ));
        }
    };
    let mut response = reply::json(StatusCode::ACCEPTED, &job)?;
    reply::locate(&mut response, format!("/jobs/{}", job.id));
    come_back(&mut response);
    Ok(response)
}

async fn from_form(
    app: &App,
    owner: &Owner,
    mut form: Form,
    key: Option<IdempotencyKey>,
) -> Result<JobRecord, Error> {
    let given = form.take_options()?;
    let file = form.file.ok_or_else(|| {
        Error::bad_request("the form has no mesh file; send one as the part mesh")
    })?;
    let seed = key.as_ref().map_or_else(random_seed, IdempotencyKey::seed);
    let request = match form.request {
        Some(_) if !form.fields.is_empty() => {
            return Err(Error::bad_request(
                "give the settings as simple fields or in the part request, not both",
            ));
        }
        Some(json) => PlanRequest::from_json(&json, seed),
        None => PlanRequest::from_form(form.fields, seed),
    };
    let request = request.map_err(Error::invalid)?;
    let key = key.map(|key| key.for_request(&request)).transpose()?;
    let MeshFile { upload, name, .. } = file;
    let incoming = MeshUpload {
        upload,
        options: MeshOptions {
            units: request.units,
            ..given
        },
        file_name: name,
    };
    let job = app
        .service
        .submit_with_upload(owner, incoming, app.limited(request), key);
    Ok(job.await?)
}

async fn from_json(
    app: &App,
    owner: &Owner,
    mut body: Value,
    key: Option<IdempotencyKey>,
) -> Result<JobRecord, Error> {
    let mesh_id = body
        .as_object_mut()
        .and_then(|object| object.remove("mesh_id"));
    if body.get("scale").is_some() {
        return Err(Error::invalid_field(
            "/scale",
            "a mesh that is here has its scale; upload the file with another one",
        ));
    }
    let seed = key.as_ref().map_or_else(random_seed, IdempotencyKey::seed);
    let request = PlanRequest::from_json(&body, seed);
    let Some(Value::String(mesh_id)) = mesh_id else {
        let mut faults = request.err().unwrap_or_default();
        faults.push(FieldError {
            pointer: "/mesh_id".to_owned(),
            detail: "the id of an uploaded mesh is wanted, as a text".to_owned(),
        });
        return Err(Error::invalid(faults));
    };
    let request = request.map_err(Error::invalid)?;
    let key = key.map(|key| key.for_request(&request)).transpose()?;
    let job = app
        .service
        .submit(owner, &mesh_id, app.limited(request), key);
    Ok(job.await?)
}

/// List jobs, newest first
#[utoipa::path(
    get, path = "/jobs",
    operation_id = "list_jobs", tag = "jobs",
    params(
        ("state" = Option<JobState>, Query, description = "Only jobs in this state"),
        ("mesh_id" = Option<String>, Query, description = "Only jobs on this mesh"),
        ("batch_id" = Option<String>, Query, description = "Only jobs of this batch"),
        ("limit" = Option<u32>, Query, minimum = 1, maximum = 1000, description = "Most items of one page; default 50"),
        ("cursor" = Option<String>, Query, description = "Where the page before this one ended, as its `next_cursor` said"),
    ),
    responses(
        (status = 200, description = "One page", body = JobPage),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 406, description = "JSON is not accepted"),
    ),
)]
pub async fn list(
    State(app): State<App>,
    Caller(owner): Caller,
    query: Parameters,
) -> Result<Response, Error> {
    let query = query.only(&["state", "mesh_id", "batch_id", "limit", "cursor"])?;
    let filter = JobFilter {
        owner,
        state: query.state()?,
        mesh_id: query.get("mesh_id").map(str::to_owned),
        batch_id: query.get("batch_id").map(str::to_owned),
    };
    let (limit, cursor) = (query.limit()?, query.get("cursor"));
    let page = app.service.jobs(&filter, limit, cursor).await?;
    reply::json(StatusCode::OK, &page)
}

/// Read a job: state, progress, effective settings
///
/// With `wait` the answer comes once the job has ended, or with the job as it is when the time is over; with
/// `If-None-Match` and the entity tag of the job as well, once anything about it has changed, progress
/// included, or with 304 when the time is over. A server that shuts down answers at once.
#[utoipa::path(
    get, path = "/jobs/{id}",
    operation_id = "read_job", tag = "jobs",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("wait" = Option<f64>, Query, minimum = 0, maximum = 60, description = "Longest that the answer may wait for the end of the job, in seconds; default 0"),
        ("If-None-Match" = Option<String>, Header, description = "The ETag of the job as the client has it"),
    ),
    responses(
        (status = 200, description = "The job", body = JobRecord, headers(
            ("ETag" = String, description = "Changes with the job; while it is unfinished, weak: the time in its progress goes on"),
            ("Retry-After" = u64, description = "While unfinished: seconds until it is worth a look"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 410, description = "The job has expired"),
        (status = 406, description = "JSON is not accepted"),
        (status = 503, description = "Too many clients wait for news of jobs"),
    ),
)]
pub async fn read(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let wait = query.only(&["wait"])?.wait()?;
    let conditional = headers.contains_key(IF_NONE_MATCH);
    let enough = |job: &JobRecord| {
        job.state.is_final() || (conditional && !reply::has(&headers, &record_tag(job)))
    };
    let job = app.service.wait_for_job(&owner, &id, wait, enough).await?;
    let tag = record_tag(&job);
    if let Some(unchanged) = reply::not_modified(&headers, &tag) {
        return Ok(unchanged);
    }
    if job.state.is_final() {
        return reply::under(&tag, &app.service.job(&owner, &id).await?);
    }
    let mut response = reply::under(&tag, &job)?;
    come_back(&mut response);
    Ok(response)
}

/// Read the result of a job
///
/// 409 until there is one: with Retry-After while the job is queued or running, without when it
/// failed (the problem tells why) or was cancelled before anything was found.
#[utoipa::path(
    get, path = "/jobs/{id}/result",
    operation_id = "read_result", tag = "jobs",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("wait" = Option<f64>, Query, minimum = 0, maximum = 60, description = "Longest that the answer may wait for the end of the job, in seconds; default 0"),
    ),
    responses(
        (status = 200, description = "The result", body = PlanResult, headers(("ETag" = String, description = "Names these bytes"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 410, description = "The job has expired"),
        (status = 406, description = "JSON is not accepted"),
        (status = 409, description = "No result yet, or the job ended without one", headers(
            ("Retry-After" = u64, description = "While unfinished: seconds until it is worth a look"))),
        (status = 503, description = "Too many clients wait for news of jobs"),
    ),
)]
pub async fn result(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let wait = query.only(&["wait"])?.wait()?;
    let ended = |job: &JobRecord| job.state.is_final();
    let job = app.service.wait_for_job(&owner, &id, wait, ended).await?;
    if !ended(&job) {
        return Err(Error::conflict("this job has not ended yet").retry_after(POLL_S));
    }
    let tag = tag(&job, "result");
    // A job that has succeeded has a result for sure; of others only a look tells.
    if job.state == JobState::Succeeded
        && let Some(unchanged) = reply::not_modified(&headers, &tag)
    {
        return Ok(unchanged);
    }
    if let Some(result) = app.service.result(&owner, &id).await? {
        return reply::not_modified(&headers, &tag).map_or_else(|| reply::under(&tag, &result), Ok);
    }
    let why = job.problem.map_or_else(
        || "it was cancelled before anything was found".to_owned(),
        |problem| format!("it failed: {}: {}", problem.title, problem.detail),
    );
    Err(Error::conflict(format!("this job has no result; {why}")))
}

/// Stop a job
///
/// What was found so far is kept and marked. A job that has ended stays as it is.
#[utoipa::path(
    post, path = "/jobs/{id}/cancel",
    operation_id = "cancel_job", tag = "jobs",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 202, description = "It will stop", body = JobRecord, headers(
            ("Retry-After" = u64, description = "Seconds until it is worth a look"))),
        (status = 200, description = "It had ended", body = JobRecord),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 410, description = "The job has expired"),
        (status = 406, description = "JSON is not accepted"),
    ),
)]
pub async fn cancel(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
) -> Result<Response, Error> {
    query.only(&[])?;
    let (job, changed) = app.service.cancel(&owner, &id).await?;
    if !changed {
        return reply::json(StatusCode::OK, &job);
    }
    let mut response = reply::json(StatusCode::ACCEPTED, &job)?;
    come_back(&mut response);
    Ok(response)
}

/// Cancel and forget a job
#[utoipa::path(
    delete, path = "/jobs/{id}",
    operation_id = "delete_job", tag = "jobs",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 204, description = "Forgotten"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 410, description = "The job has expired"),
    ),
)]
pub async fn delete(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
) -> Result<Response, Error> {
    query.only(&[])?;
    app.service.delete_job(&owner, &id).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}

/// The entity tag of a job or of its result, known without the bytes. Of an ended job neither changes any
/// more; the record of any other changes with its revision but for the time in its progress.
fn tag(job: &JobRecord, part: &str) -> String {
    let weak = if job.state.is_final() { "" } else { "W/" };
    format!("{weak}\"{}-{}-{part}\"", job.id, job.revision)
}

/// The entity tag of a record, in which the callback changes after the end too.
fn record_tag(job: &JobRecord) -> String {
    match &job.callback {
        None => tag(job, "job"),
        Some(callback) => {
            let part = format!("job-{}-{}", callback.state.name(), callback.attempts);
            tag(job, &part)
        }
    }
}

/// Says when an unfinished job is worth another look.
pub(super) fn come_back(response: &mut Response) {
    response
        .headers_mut()
        .insert(RETRY_AFTER, HeaderValue::from(POLL_S));
}
