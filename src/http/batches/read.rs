//! Lists batches, and reads one.

use std::time::Duration;

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::request::query::{DEFAULT_LIMIT, Name, PageQuery, WaitQuery};
use crate::http::response::conditional;
use crate::http::response::error::Error;
use crate::http::response::json;
use crate::wire::{BatchPage, BatchRecord, BatchState};

/// List batches, newest first
#[utoipa::path(
    get, path = "/batches", params(PageQuery),
    responses((status = 200, description = "One page", body = BatchPage)),
)]
pub async fn list_batches(
    State(app): State<App>,
    Caller(owner): Caller,
    query: PageQuery,
) -> Result<Response, Error> {
    let limit = query.limit.unwrap_or(DEFAULT_LIMIT);
    let page = app.service.batches(&owner, limit, query.cursor.as_deref());
    json::json(StatusCode::OK, &page.await?)
}

/// Read a batch: how many of its jobs are in each state
///
/// With `wait` the answer comes once the batch has ended, or when the time is over, with the batch as it is. A server
/// that shuts down answers at once.
#[utoipa::path(
    get, path = "/batches/{id}", params(WaitQuery),
    responses((status = 200, description = "The batch", body = BatchRecord, headers(
        ("ETag" = String, description = "Names these bytes"),
        ("Retry-After" = u64, description = "While the batch runs: seconds until it is worth a look")))),
)]
pub async fn read_batch(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: WaitQuery,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let wait = query.wait.unwrap_or(Duration::ZERO);
    let batch = app.service.wait_for_batch(&owner, &id, wait).await?;
    let mut response = conditional::hashed_json(&headers, &batch)?;
    if batch.state == BatchState::Running {
        json::set_retry_after(&mut response);
    }
    Ok(response)
}
