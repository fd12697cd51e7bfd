//! Given grasps, evaluated and answered at once.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use serde_json::Value;

use super::access::Caller;
use super::body::{Large, apart};
use super::error::Error;
use super::form::{self, Form};
use super::openapi::{EvaluationForm, EvaluationJson};
use super::query::Parameters;
use super::{App, body, reply};
use crate::jobs::Owner;
use crate::wire::{EvaluationRequest, Evaluations, FieldError, MAX_EVALUATION_BYTES};

/// Evaluate grasps
///
/// Quality, certified bounds, all measures, least-effort contact forces and, without force closure, the
/// reason, of 1 to 10,000 given grasps, answered at once in their order. As JSON with the `mesh_id` of an
/// uploaded mesh, or as a multipart form with the mesh file in the part `mesh` (of which nothing is kept), the
/// grasps as JSON in the part `grasps` and each setting as a simple field, or all of them as JSON in one
/// part `request`. Robustness, independent regions and quality for tasks are told where they are asked for. A
/// call may have 8 MiB and take 30 s.
#[utoipa::path(
    post, path = "/evaluations",
    operation_id = "evaluate", tag = "evaluations",
    request_body(content((EvaluationJson = "application/json"), (EvaluationForm = "multipart/form-data"))),
    responses(
        (status = 200, description = "The evaluations, in the order of the grasps", body = Evaluations),
        (status = 400, description = "Malformed JSON or form, no file, two files"),
        (status = 406, description = "JSON is not accepted"),
        (status = 408, description = "The body came too slowly"),
        (status = 413, description = "Larger than the server takes"),
        (status = 415, description = "Neither form nor JSON, or no mesh in a supported format"),
        (status = 422, description = "Settings, contacts or a mesh that cannot be used, an unknown mesh_id, or more than 30 s of work; errors say which"),
        (status = 503, description = "The server is shutting down"),
        (status = 507, description = "The disk of the server is full"),
    ),
)]
pub async fn evaluate(
    State(app): State<App>,
    Caller(owner): Caller,
    query: Parameters,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Error> {
    query.only(&[])?;
    let limit = MAX_EVALUATION_BYTES;
    let found = match body::media_type(&headers)?.as_deref() {
        Some("application/json") => {
            let body = body::read_large(&app.large_bodies, request, limit as u64).await?;
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
    apart(move || reply::json(StatusCode::OK, &found)).await
}

async fn from_json(app: &App, owner: &Owner, body: Large) -> Result<Evaluations, Error> {
    let Large { bytes, place } = body;
    let (mesh_id, request) = apart(move || parse(&bytes)).await?;
    let found = app.service.evaluate(owner, &mesh_id, request).await?;
    drop(place);
    Ok(found)
}

/// The id of the mesh and the request.
fn parse(body: &[u8]) -> Result<(String, EvaluationRequest), Error> {
    let mut body = body::parse_json(body, MAX_EVALUATION_BYTES)?;
    let mesh_id = body
        .as_object_mut()
        .and_then(|object| object.remove("mesh_id"));
    let request = EvaluationRequest::from_json(&body);
    let Some(Value::String(mesh_id)) = mesh_id else {
        let mut faults = request.err().unwrap_or_default();
        faults.push(FieldError {
            pointer: "/mesh_id".to_owned(),
            detail: "the id of an uploaded mesh is wanted, as a text".to_owned(),
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
    let request = apart(move || {
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
    drop(form.place);
    Ok(found)
}
