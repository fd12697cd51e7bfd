//! Cancels and deletes jobs.

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::request::query::{Name, NoQuery};
use crate::http::response::error::Error;
use crate::http::response::json;
use crate::wire::JobRecord;

/// Stop a job
///
/// What was found so far is kept and marked. A job that has ended stays as it is.
#[utoipa::path(
    post, path = "/jobs/{id}/cancel",
    responses(
        (status = 202, description = "It will stop", body = JobRecord),
        (status = 200, description = "It had ended", body = JobRecord),
    ),
)]
pub async fn cancel_job(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    _: NoQuery,
) -> Result<Response, Error> {
    let (job, changed) = app.service.cancel(&owner, &id).await?;
    if !changed {
        return json::json(StatusCode::OK, &job);
    }
    let mut response = json::json(StatusCode::ACCEPTED, &job)?;
    json::set_retry_after(&mut response);
    Ok(response)
}

/// Cancel and forget a job
#[utoipa::path(
    delete, path = "/jobs/{id}",
    responses((status = 204, description = "Forgotten")),
)]
pub async fn delete_job(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    _: NoQuery,
) -> Result<Response, Error> {
    app.service.delete_job(&owner, &id).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}
