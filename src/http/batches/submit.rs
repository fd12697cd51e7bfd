//! Submits batches.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::openapi::bodies::BatchBody;
use crate::http::openapi::headers::IdempotencyKeyHeader;
use crate::http::request::large::LargeBody;
use crate::http::request::query::NoQuery;
use crate::http::request::{idempotency, json_body, media_type};
use crate::http::response::error::Error;
use crate::http::response::json;
use crate::jobs::IdempotencyKey;
use crate::wire::{BatchRecord, BatchRequest, MAX_BATCH_BYTES, random_seed};

/// Submit many jobs as one
///
/// Either `meshes`, the ids of uploaded meshes, with one `request` for all of them, or `requests`, each with its
/// `mesh_id`; 1 to 10,000 jobs in at most 8 MiB. All of them are queued, in this order, or none. Their `priority`
/// is `batch` unless it is given; a seed that is not given differs from job to job. The answer comes once all
/// of them are safely stored.
#[utoipa::path(
    post, path = "/batches", params(IdempotencyKeyHeader),
    request_body(content((BatchBody = "application/json"))),
    responses(
        (status = 202, description = "Accepted", body = BatchRecord),
        (status = 400, description = "Malformed JSON"),
        (status = 415, description = "Not JSON"),
        (status = 422, description = "Settings that cannot be used, an unknown mesh, a callback_url that is not allowed, more jobs than an empty queue has room for, or an Idempotency-Key that another request was sent under; errors say which"),
        (status = 503, description = "The queue has too little room for all of them now, or the server is shutting down"),
    ),
)]
pub async fn submit_batch(
    State(app): State<App>,
    Caller(owner): Caller,
    _: NoQuery,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Error> {
    let key = idempotency::begin(&app.service, &owner, &headers)?;
    if media_type::of_body(&headers)?.as_deref() != Some("application/json") {
        return Err(Error::unsupported("send application/json"));
    }
    let body = app.large_bodies.read(request, MAX_BATCH_BYTES as u64);
    let LargeBody { bytes, permit } = body.await?;
    let (mut batch, key) = json_body::run_blocking(move || parse(&bytes, key)).await?;
    for job in &mut batch.jobs {
        app.limit(&mut job.request);
    }
    let batch = app.service.submit_batch(&owner, batch, key).await?;
    drop(permit);
    let mut response = json::json(StatusCode::ACCEPTED, &batch)?;
    json::set_location(&mut response, format!("/batches/{}", batch.id));
    json::set_retry_after(&mut response);
    Ok(response)
}

fn parse(
    bytes: &[u8],
    key: Option<IdempotencyKey>,
) -> Result<(BatchRequest, Option<IdempotencyKey>), Error> {
    let value = json_body::parse(bytes, MAX_BATCH_BYTES)?;
    let seed = |index| {
        key.as_ref()
            .map_or_else(random_seed, |key| key.seed_at(index))
    };
    let batch = BatchRequest::from_json(value, seed).map_err(Error::invalid)?;
    let key = key.map(|key| key.for_batch(&batch)).transpose()?;
    Ok((batch, key))
}
