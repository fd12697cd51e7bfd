//! Cancels and deletes batches.

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::request::query::{Name, NoQuery};
use crate::http::response::error::Error;
use crate::http::response::json;
use crate::wire::BatchRecord;

/// Stop all jobs of a batch
///
/// What was found so far is kept and marked. Jobs that have ended stay as they are.
#[utoipa::path(
    post, path = "/batches/{id}/cancel",
    responses(
        (status = 202, description = "Its jobs will stop", body = BatchRecord),
        (status = 200, description = "There was nothing left to stop", body = BatchRecord),
    ),
)]
pub async fn cancel_batch(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    _: NoQuery,
) -> Result<Response, Error> {
    let (batch, changed) = app.service.cancel_batch(&owner, &id).await?;
    if !changed {
        return json::json(StatusCode::OK, &batch);
    }
    let mut response = json::json(StatusCode::ACCEPTED, &batch)?;
    json::set_retry_after(&mut response);
    Ok(response)
}

/// Cancel and forget a batch and its jobs
#[utoipa::path(
    delete, path = "/batches/{id}",
    responses((status = 204, description = "Forgotten")),
)]
pub async fn delete_batch(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    _: NoQuery,
) -> Result<Response, Error> {
    app.service.delete_batch(&owner, &id).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}
