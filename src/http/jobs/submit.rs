//! Submits planning jobs.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use serde_json::Value;

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::openapi::bodies::{JobForm, JobRequest};
use crate::http::openapi::headers::IdempotencyKeyHeader;
use crate::http::request::form::{self, Form, MeshFile};
use crate::http::request::query::NoQuery;
use crate::http::request::{idempotency, json_body, media_type};
use crate::http::response::error::Error;
use crate::http::response::json;
use crate::jobs::{IdempotencyKey, MeshUpload, Owner};
use crate::wire::json::MAX_JSON_BYTES;
use crate::wire::{FieldError, JobRecord, MeshOptions, PlanRequest, random_seed};

/// Plan a grasp
///
/// As a multipart form with the mesh file in the part `mesh` and each setting as a simple field
/// (or all of them as JSON in one part `request`), or as JSON with the `mesh_id` of an uploaded
/// mesh. The answer comes once job and mesh are safely stored.
#[utoipa::path(
    post, path = "/jobs", params(IdempotencyKeyHeader),
    request_body(content((JobForm = "multipart/form-data"), (JobRequest = "application/json"))),
    responses(
        (status = 202, description = "Accepted", body = JobRecord),
        (status = 400, description = "Malformed JSON or form, no file, two files"),
        (status = 415, description = "Neither form nor JSON, or no mesh in a supported format"),
        (status = 422, description = "Settings or a mesh that cannot be used, an unknown mesh_id, a callback_url that is not allowed, or an Idempotency-Key that another request was sent under; errors say which"),
        (status = 503, description = "The queue is full, or the server is shutting down"),
    ),
)]
pub async fn submit_job(
    State(app): State<App>,
    Caller(owner): Caller,
    _: NoQuery,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Error> {
    let key = idempotency::begin(&app.service, &owner, &headers)?;
    let job = match media_type::of_body(&headers)?.as_deref() {
        Some("multipart/form-data") => {
            let form = form::read(&app, request, MAX_JSON_BYTES).await?;
            from_form(&app, &owner, form, key).await?
        }
        Some("application/json") => {
            let body = json_body::read(request, MAX_JSON_BYTES).await?;
            from_json(&app, &owner, body, key).await?
        }
        _ => {
            return Err(Error::unsupported(
                "send multipart/form-data with the mesh file, or application/json with mesh_id",
            ));
        }
    };
    let mut response = json::json(StatusCode::ACCEPTED, &job)?;
    json::set_location(&mut response, format!("/jobs/{}", job.id));
    json::set_retry_after(&mut response);
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
    let mut request = request.map_err(Error::invalid)?;
    let key = key.map(|key| key.for_request(&request)).transpose()?;
    app.limit(&mut request);
    let MeshFile { upload, name, .. } = file;
    let incoming = MeshUpload {
        upload,
        options: MeshOptions {
            units: request.quality.units,
            ..given
        },
        file_name: name,
    };
    let job = app
        .service
        .submit_with_upload(owner, incoming, request, key);
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
            "an uploaded mesh has its scale already; upload the file again with another one",
        ));
    }
    let seed = key.as_ref().map_or_else(random_seed, IdempotencyKey::seed);
    let request = PlanRequest::from_json(&body, seed);
    let Some(Value::String(mesh_id)) = mesh_id else {
        let mut faults = request.err().unwrap_or_default();
        faults.push(FieldError {
            pointer: "/mesh_id".to_owned(),
            detail: "must be the id of an uploaded mesh, as a string".to_owned(),
        });
        return Err(Error::invalid(faults));
    };
    let mut request = request.map_err(Error::invalid)?;
    let key = key.map(|key| key.for_request(&request)).transpose()?;
    app.limit(&mut request);
    let job = app.service.submit(owner, &mesh_id, request, key);
    Ok(job.await?)
}
