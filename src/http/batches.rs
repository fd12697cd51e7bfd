//! Batches: submit, list, read, results, cancel, forget.

use axum::body::{Body, Bytes};
use axum::extract::{Request, State};
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use futures_util::stream;

use super::access::Caller;
use super::body::Large;
use super::error::Error;
use super::jobs::come_back;
use super::openapi::BatchBody;
use super::query::{Name, Parameters};
use super::{App, body, once, reply};
use crate::jobs::{IdempotencyKey, Owner};
use crate::wire::{
    BatchId, BatchPage, BatchRecord, BatchRequest, BatchResult, BatchState, JobState,
    MAX_BATCH_BYTES, random_seed,
};

/// One JSON document a line.
const NDJSON: &str = "application/x-ndjson";

/// Submit many jobs as one
///
/// Either `meshes`, the ids of uploaded meshes, with one `request` for all of them, or `requests`, each with its
/// `mesh_id`; 1 to 10,000 jobs in at most 8 MiB. All of them are queued, in this order, or none. Their `priority`
/// is `batch` unless it is given; a seed that is not given differs from job to job. The answer comes once all
/// are safely stored.
#[utoipa::path(
    post, path = "/batches",
    operation_id = "submit_batch", tag = "batches",
    params(("Idempotency-Key" = Option<String>, Header, min_length = 1, max_length = 255, description = "A key of the client's choice, such as a UUID: in the next 24 hours the same request under the same key makes no second batch but answers the first")),
    request_body(content((BatchBody = "application/json"))),
    responses(
        (status = 202, description = "Accepted", body = BatchRecord, headers(
            ("Location" = String, description = "Where the batch is"),
            ("Retry-After" = u64, description = "Seconds until it is worth a look"))),
        (status = 400, description = "Malformed JSON"),
        (status = 406, description = "JSON is not accepted"),
        (status = 408, description = "The body came too slowly"),
        (status = 409, description = "A submission under the same Idempotency-Key is under way"),
        (status = 410, description = "The batch of this Idempotency-Key has been deleted"),
        (status = 413, description = "Larger than the server takes"),
        (status = 415, description = "Not JSON"),
        (status = 422, description = "Settings that cannot be used, an unknown mesh, a callback_url that is not allowed, more jobs than an empty queue has room for, or an Idempotency-Key that another request was sent under; errors say which"),
        (status = 503, description = "The queue has too little room for all of them now, or the server is shutting down"),
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
    if body::media_type(&headers)?.as_deref() != Some("application/json") {
        return Err(Error::unsupported("send application/json"));
    }
    let body = body::read_large(&app.large_bodies, request, MAX_BATCH_BYTES as u64).await?;
    let Large { bytes, place } = body;
    let (mut batch, key) = body::apart(move || parse(&bytes, key)).await?;
    for job in &mut batch.jobs {
        app.limit(&mut job.request);
    }
    let batch = app.service.submit_batch(&owner, batch, key).await?;
    drop(place);
    let mut response = reply::json(StatusCode::ACCEPTED, &batch)?;
    reply::locate(&mut response, format!("/batches/{}", batch.id));
    come_back(&mut response);
    Ok(response)
}

fn parse(
    bytes: &[u8],
    key: Option<IdempotencyKey>,
) -> Result<(BatchRequest, Option<IdempotencyKey>), Error> {
    let value = body::parse_json(bytes, MAX_BATCH_BYTES)?;
    let seed = |index| {
        key.as_ref()
            .map_or_else(random_seed, |key| key.seed_at(index))
    };
    let batch = BatchRequest::from_json(value, seed).map_err(Error::invalid)?;
    let key = key.map(|key| key.for_batch(&batch)).transpose()?;
    Ok((batch, key))
}

/// List batches, newest first
#[utoipa::path(
    get, path = "/batches",
    operation_id = "list_batches", tag = "batches",
    params(
        ("limit" = Option<u32>, Query, minimum = 1, maximum = 1000, description = "Most items of one page; default 50"),
        ("cursor" = Option<String>, Query, description = "Where the page before this one ended, as its `next_cursor` said"),
    ),
    responses(
        (status = 200, description = "One page", body = BatchPage),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 406, description = "JSON is not accepted"),
    ),
)]
pub async fn list(
    State(app): State<App>,
    Caller(owner): Caller,
    query: Parameters,
) -> Result<Response, Error> {
    let query = query.only(&["limit", "cursor"])?;
    let (limit, cursor) = (query.limit()?, query.get("cursor"));
    let page = app.service.batches(&owner, limit, cursor).await?;
    reply::json(StatusCode::OK, &page)
}

/// Read a batch: how many of its jobs are in each state
///
/// With `wait` the answer comes once the batch has ended, or with the batch as it is when the time is over. A
/// server that shuts down answers at once.
#[utoipa::path(
    get, path = "/batches/{id}",
    operation_id = "read_batch", tag = "batches",
    params(
        ("id" = String, Path, description = "Id of the batch"),
        ("wait" = Option<f64>, Query, minimum = 0, maximum = 60, description = "Longest that the answer may wait for the end of the batch, in seconds; default 0"),
    ),
    responses(
        (status = 200, description = "The batch", body = BatchRecord, headers(
            ("ETag" = String, description = "Names these bytes"),
            ("Retry-After" = u64, description = "While it runs: seconds until it is worth a look"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such batch"),
        (status = 410, description = "The batch has expired"),
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
    let batch = app.service.wait_for_batch(&owner, &id, wait).await?;
    let mut response = reply::tagged(&headers, &batch)?;
    if batch.state == BatchState::Running {
        come_back(&mut response);
    }
    Ok(response)
}

/// Read what became of the jobs of a batch
///
/// One JSON document a line and one line a job, in the order of the batch, while it runs too: a job that has not
/// ended is told with its state alone, and one that was deleted or has expired not at all. A body that ends
/// within a line was cut off; `after` goes on behind the last whole one.
#[utoipa::path(
    get, path = "/batches/{id}/results",
    operation_id = "read_batch_results", tag = "batches",
    params(
        ("id" = String, Path, description = "Id of the batch"),
        ("state" = Option<JobState>, Query, description = "Only jobs in this state"),
        ("after" = Option<u32>, Query, minimum = 0, maximum = 9999, description = "Only jobs behind this `index`"),
    ),
    responses(
        (status = 200, description = "The lines", content((BatchResult = "application/x-ndjson"))),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such batch"),
        (status = 410, description = "The batch has expired"),
        (status = 406, description = "NDJSON is not accepted"),
    ),
)]
pub async fn results(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let query = query.only(&["state", "after"])?;
    let state = query.state()?;
    let after = query.parse("after", "a whole number from 0 to 9999", |text| {
        text.parse().ok().filter(|after| *after < 10_000)
    })?;
    reply::accepted(&headers, NDJSON)?;
    let id = app.service.batch(&owner, &id).await?.id;
    let mut lines = Lines {
        app,
        owner,
        id,
        state,
        after,
    };
    // What goes wrong at once can still be told.
    let first = lines.next().await?;
    let begun = first.map(|first| (Some(first), lines));
    let lines = stream::try_unfold(begun, |begun| async {
        let Some((first, mut lines)) = begun else {
            return Ok(None);
        };
        let piece = match first {
            Some(first) => Some(first),
            None => lines.next().await.map_err(cut_off)?,
        };
        Ok::<_, std::io::Error>(piece.map(|piece| (piece, Some((None, lines)))))
    });
    Ok(([(CONTENT_TYPE, NDJSON)], Body::from_stream(lines)).into_response())
}

/// The results of a batch, a few at a time.
struct Lines {
    app: App,
    owner: Owner,
    id: BatchId,
    state: Option<JobState>,
    after: Option<u32>,
}

impl Lines {
    /// The next lines, if there are any.
    async fn next(&mut self) -> Result<Option<Bytes>, Error> {
        let service = &self.app.service;
        let results = service.batch_results(&self.owner, self.id, self.state, self.after);
        let results: Vec<BatchResult> = results.await?;
        let Some(last) = results.last() else {
            return Ok(None);
        };
        self.after = Some(last.index);
        let mut lines = Vec::new();
        for result in &results {
            serde_json::to_writer(&mut lines, result).map_err(Error::internal)?;
            lines.push(b'\n');
        }
        Ok(Some(lines.into()))
    }
}

/// The status is long gone: the client sees a body that does not end.
fn cut_off(refused: Error) -> std::io::Error {
    std::io::Error::other(refused.problem().detail.clone())
}

/// Stop all jobs of a batch
///
/// What was found so far is kept and marked. Jobs that have ended stay as they are.
#[utoipa::path(
    post, path = "/batches/{id}/cancel",
    operation_id = "cancel_batch", tag = "batches",
    params(("id" = String, Path, description = "Id of the batch")),
    responses(
        (status = 202, description = "Its jobs will stop", body = BatchRecord, headers(
            ("Retry-After" = u64, description = "Seconds until it is worth a look"))),
        (status = 200, description = "There was nothing left to stop", body = BatchRecord),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such batch"),
        (status = 410, description = "The batch has expired"),
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
    let (batch, changed) = app.service.cancel_batch(&owner, &id).await?;
    if !changed {
        return reply::json(StatusCode::OK, &batch);
    }
    let mut response = reply::json(StatusCode::ACCEPTED, &batch)?;
    come_back(&mut response);
    Ok(response)
}

/// Cancel and forget a batch and its jobs
#[utoipa::path(
    delete, path = "/batches/{id}",
    operation_id = "delete_batch", tag = "batches",
    params(("id" = String, Path, description = "Id of the batch")),
    responses(
        (status = 204, description = "Forgotten"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such batch"),
        (status = 410, description = "The batch has expired"),
    ),
)]
pub async fn delete(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
) -> Result<Response, Error> {
    query.only(&[])?;
    app.service.delete_batch(&owner, &id).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}
