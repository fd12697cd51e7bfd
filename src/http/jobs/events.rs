//! The life of a job as Server-Sent Events.

use std::time::Duration;

use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::{Stream, stream};
use serde::Serialize;
use utoipa::ToSchema;

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::request::accept;
use crate::http::request::query::{Name, NoQuery};
use crate::http::response::error::Error;
use crate::jobs::Follower;
use crate::wire::{JobProgress, JobRecord};

const MEDIA_TYPE: &str = "text/event-stream";
const LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");
/// Keeps buffering proxies from holding events back.
const UNBUFFERED: (HeaderName, HeaderValue) = (
    HeaderName::from_static("x-accel-buffering"),
    HeaderValue::from_static("no"),
);
/// The longest silence. After it a comment keeps the connection open, and a reader that is gone shows.
const HEARTBEAT: Duration = Duration::from_secs(10);
/// Revisions are kept as signed numbers of 64 bits.
const MAX_REVISION: u64 = i64::MAX as u64;
/// How long a reader waits before it opens a broken stream again.
const RETRY: Duration = Duration::from_secs(2);

/// Follow a job
///
/// Server-Sent Events, each with one line of JSON: first `snapshot`, the job as `GET /jobs/{id}` returns it but
/// without its result; then `progress` with revision, state and progress, whenever they change, at most 20
/// times a second; last `end`, once, the job again, whose result is at `/jobs/{id}/result`. The id of an event is the
/// revision of the job. It only ever grows, also when the server is started again. A slow reader gets the newest
/// state and misses those in between.
///
/// A reader that sends the last id it has seen as `Last-Event-ID`, as browsers do by themselves, gets only what
/// is newer, without another snapshot, and 204 when it has seen the end. The snapshot of a job that has ended
/// has no id, which is that of the `end` behind it. A stream that breaks off before `end` is to be opened again:
/// the server is shutting down, or the job was forgotten, which is a 404 then.
#[utoipa::path(
    get, path = "/jobs/{id}/events",
    params(("Last-Event-ID" = Option<u64>, Header, description = "Revision of the job that the client has seen")),
    responses(
        (status = 200, description = "The events: `snapshot` and `end` with a `JobRecord`, `progress` with a `JobProgress`",
            content((JobEvent = "text/event-stream"))),
        (status = 204, description = "The client has seen the end"),
        (status = 400, description = "A Last-Event-ID that is no revision, or a query parameter"),
        (status = 503, description = "Too many clients wait for news of jobs"),
    ),
)]
pub async fn follow_job(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Result<NoQuery, Error>,
    headers: HeaderMap,
) -> Result<Response, Error> {
    accept::require(&headers, MEDIA_TYPE)?;
    query?;
    let seen = last_event_id(&headers)?;
    let follower = app.service.follow(&owner, &id).await?;
    let job = follower.current();
    let from = match seen {
        None => Next::Snapshot,
        Some(seen) if job.state.is_final() && seen >= job.revision => {
            return Ok(StatusCode::NO_CONTENT.into_response());
        }
        // A client may name a revision that never was; it gets the next change.
        Some(seen) => Next::After(seen.min(job.revision)),
    };
    let heartbeat = KeepAlive::new().interval(HEARTBEAT);
    let events = Sse::new(job_events(follower, from)).keep_alive(heartbeat);
    Ok(([UNBUFFERED], events).into_response())
}

/// One event.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes a stream that axum writes")]
pub struct JobEvent {
    /// `snapshot`, `progress` or `end`.
    event: String,
    /// A `JobRecord` or a `JobProgress` as one line of JSON.
    data: String,
    /// Revision of the job.
    #[schema(nullable = false)]
    id: Option<String>,
    /// Milliseconds to wait before the stream is opened again.
    #[schema(nullable = false)]
    retry: Option<u64>,
}

/// The events that are still to be sent.
enum Next {
    /// The snapshot.
    Snapshot,
    /// The first change after this revision.
    After(u64),
}

/// Returns the events of a job. The stream ends after `end`, and when the job can no longer be followed.
fn job_events(follower: Follower, from: Next) -> impl Stream<Item = Result<Event, axum::Error>> {
    let first = true;
    stream::unfold(Some((follower, from, first)), async |state| {
        let (mut follower, from, first) = state?;
        let (event, next) = match from {
            Next::Snapshot => {
                let job = follower.current();
                // The id of an ended job would say that its end was seen.
                let (id, seen) = match job.state.is_final() {
                    true => (None, job.revision - 1),
                    false => (Some(job.revision), job.revision),
                };
                (event("snapshot", id, &job), Some(Next::After(seen)))
            }
            Next::After(seen) => {
                let job = follower.next_after(seen).await.ok().flatten()?;
                let revision = job.revision;
                match job.state.is_final() {
                    true => (event("end", Some(revision), &job), None),
                    false => {
                        let sent = event("progress", Some(revision), &progress(job));
                        (sent, Some(Next::After(revision)))
                    }
                }
            }
        };
        let event = if first {
            event.map(|event| event.retry(RETRY))
        } else {
            event
        };
        Some((event, next.map(|next| (follower, next, false))))
    })
}

fn event(name: &str, id: Option<u64>, data: &impl Serialize) -> Result<Event, axum::Error> {
    let event = Event::default().event(name).json_data(data)?;
    Ok(match id {
        Some(id) => event.id(id.to_string()),
        None => event,
    })
}

fn progress(job: JobRecord) -> JobProgress {
    JobProgress {
        revision: job.revision,
        state: job.state,
        progress: job.progress,
    }
}

fn last_event_id(headers: &HeaderMap) -> Result<Option<u64>, Error> {
    let mut given = headers.get_all(LAST_EVENT_ID).iter();
    let Some(id) = given.next() else {
        return Ok(None);
    };
    let revision = id
        .to_str()
        .ok()
        .filter(|id| id.bytes().all(|byte| byte.is_ascii_digit()))
        .and_then(|id| id.parse().ok())
        .filter(|revision| *revision <= MAX_REVISION);
    match (revision, given.next()) {
        (Some(revision), None) => Ok(Some(revision)),
        _ => Err(Error::bad_request(
            "the Last-Event-ID is no revision; send the id of the last event that was seen, or none",
        )),
    }
}
