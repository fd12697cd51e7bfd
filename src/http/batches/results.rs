//! The results of a batch, streamed line by line.

use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use futures_util::stream;

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::request::accept;
use crate::http::request::query::{Name, Param, STATE, query, whole_number};
use crate::http::response::error::Error;
use crate::jobs::Owner;
use crate::wire::{BatchId, BatchResult, JobState, MAX_BATCH_JOBS};

/// One JSON document a line.
const NDJSON: &str = "application/x-ndjson";
const MAX_INDEX: u32 = MAX_BATCH_JOBS as u32 - 1;

const AFTER: Param<u32> = Param {
    name: "after",
    description: "Only jobs behind this `index`",
    expected: "a whole number from 0 to 9999",
    parse: |text| text.parse().ok().filter(|after| *after <= MAX_INDEX),
    schema: || whole_number(0, MAX_INDEX),
};

query! {
    /// Which results to read.
    pub struct ResultsQuery { state: JobState = STATE, after: u32 = AFTER }
}

/// Read the results of the jobs of a batch
///
/// One JSON document a line and one line for each job, in the order of the batch, also while it runs: a job that has
/// not ended has its state alone, and one that was deleted or has expired is left out. A body that ends within a line
/// was cut off; `after` continues behind the last whole line.
#[utoipa::path(
    get, path = "/batches/{id}/results", params(ResultsQuery),
    responses((status = 200, description = "The lines", content((BatchResult = "application/x-ndjson")))),
)]
pub async fn read_batch_results(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: ResultsQuery,
    headers: HeaderMap,
) -> Result<Response, Error> {
    accept::require(&headers, NDJSON)?;
    let id = app.service.batch(&owner, &id).await?.id;
    let mut lines = Lines {
        app,
        owner,
        id,
        state: query.state,
        after: query.after,
    };
    // A failure before the first line can still be answered with a status.
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

/// The status was sent long ago, so the client sees a body without its end.
fn cut_off(refused: Error) -> std::io::Error {
    std::io::Error::other(refused.problem().detail.clone())
}
