//! Evaluates given grasps and answers at once.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use serde_json::Value;

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::openapi::bodies::{EvaluationForm, EvaluationJson};
use crate::http::request::form::{self, Form};
use crate::http::request::json_body::run_blocking;
use crate::http::request::large::LargeBody;
use crate::http::request::query::NoQuery;
use crate::http::request::{json_body, media_type};
use crate::http::response::error::Error;
use crate::http::response::json;
use crate::jobs::Owner;
use crate::wire::{EvaluationRequest, Evaluations, FieldError, MAX_EVALUATION_BYTES};

/// Evaluate grasps
///
/// Quality, certified bounds, all measures, least-effort contact forces and, without force closure, the
/// reason, of 1 to 10,000 given grasps, answered at once in their order. As JSON with the `mesh_id` of an
/// uploaded mesh, or as a multipart form with the mesh file in the part `mesh` (of which nothing is kept), the
/// grasps as JSON in the part `grasps` and each setting as a simple field, or all of them as JSON in one
/// part `request`. Robustness, independent regions and quality for tasks are included on request. A
/// call may have 8 MiB and take 30 s.
#[utoipa::path(
    post, path = "/evaluations",
    request_body(content((EvaluationJson = "application/json"), (EvaluationForm = "multipart/form-data"))),
    responses(
        (status = 200, description = "The evaluations, in the order of the grasps", body = Evaluations),
        (status = 400, description = "Malformed JSON or form, no file, two files"),
        (status = 415, description = "Neither form nor JSON, or no mesh in a supported format"),
        (status = 422, description = "Settings, contacts or a mesh that cannot be used, an unknown mesh_id, or more than 30 s of work; errors say which"),
        (status = 503, description = "The server is shutting down"),
    ),
)]
pub async fn evaluate(
    State(app): State<App>,
    Caller(owner): Caller,
    _: NoQuery,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Error> {
    let limit = MAX_EVALUATION_BYTES;
    let found = match media_type::of_body(&headers)?.as_deref() {
        Some("application/json") => {
            let body = app.large_bodies.read(request, limit as u64).await?;
            from_json(&app, &owner, body).await?
        }
        Some("multipart/form-data") => {
            from_form(&app, form::read(&app, request, limit).await?).await?
        }
        _ => {
            return Err(Error::unsupported(
                "send application/json with mesh_id, or multipart/form-data with the mesh file",
            ));
        }
    };
    run_blocking(move || json::json(StatusCode::OK, &found)).await
}

async fn from_json(app: &App, owner: &Owner, body: LargeBody) -> Result<Evaluations, Error> {
    let LargeBody { bytes, permit } = body;
    let (mesh_id, request) = run_blocking(move || parse(&bytes)).await?;
    let found = app.service.evaluate(owner, &mesh_id, request).await?;
    drop(permit);
    Ok(found)
}

/// Returns the id of the mesh and the request.
fn parse(body: &[u8]) -> Result<(String, EvaluationRequest), Error> {
    let mut body = json_body::parse(body, MAX_EVALUATION_BYTES)?;
    let mesh_id = body
        .as_object_mut()
        .and_then(|object| object.remove("mesh_id"));
    let request = EvaluationRequest::from_json(&body);
    let Some(Value::String(mesh_id)) = mesh_id else {
        let mut faults = request.err().unwrap_or_default();
        faults.push(FieldError {
            pointer: "/mesh_id".to_owned(),
            detail: "must be the id of an uploaded mesh, as a string".to_owned(),
        });
        return Err(Error::invalid(faults));
    };
    Ok((mesh_id, request.map_err(Error::invalid)?))
}

async fn from_form(app: &App, mut form: Form) -> Result<Evaluations, Error> {
    let options = form.take_options()?;
    let file = form.file.ok_or_else(|| {
        Error::bad_request("the form has no mesh file; send one as the part mesh")
    })?;
    let (whole, fields) = (form.request, form.fields);
    let request = run_blocking(move || {
        let request = match whole {
            Some(_) if !fields.is_empty() => {
                return Err(Error::bad_request(
                    "give the settings as simple fields or in the part request, not both",
                ));
            }
            Some(json) => EvaluationRequest::from_json(&json),
            None => EvaluationRequest::from_form(fields),
        };
        request.map_err(Error::invalid)
    })
    .await?;
    let evaluated = app.service.evaluate_upload(file.upload, options, request);
    let found = evaluated.await?;
    drop(form.permit);
    Ok(found)
}
