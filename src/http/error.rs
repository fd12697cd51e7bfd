//! The one error type at the HTTP edge.

use axum::http::header::{ALLOW, CONTENT_TYPE, RETRY_AFTER, WWW_AUTHENTICATE};
use axum::http::{HeaderName, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use jiff::fmt::rfc2822::DateTimePrinter;

use super::rate::Standing;
use crate::jobs::{self, StoreError};
use crate::wire::{FieldError, Problem, text};

/// Media type of every error.
pub const PROBLEM_JSON: &str = "application/problem+json";

/// Seconds after which a client may try again when nothing better is known.
const RETRY_AFTER_S: u64 = 5;
/// The same for room, which only comes free when meshes expire or are deleted.
const ROOM_RETRY_AFTER_S: u64 = 60;

/// A refused request: a [`Problem`] on its way out, with the headers its status asks for.
#[derive(Debug)]
pub struct Error {
    problem: Box<Problem>,
    headers: Vec<(HeaderName, HeaderValue)>,
}

impl Error {
    /// 400: the request is not well formed.
    pub fn bad_request(detail: impl Into<String>) -> Self {
        Problem::new(400, "bad-request", "Bad request", detail).into()
    }

    /// 400: a query parameter is unknown, repeated or out of range.
    pub fn query(name: &str, detail: impl Into<String>) -> Self {
        Problem::new(
            400,
            "invalid-query",
            "Invalid query",
            "a query parameter cannot be used; see errors",
        )
        .with_errors(vec![FieldError {
            pointer: text::pointer(name),
            detail: detail.into(),
        }])
        .into()
    }

    /// 401: no key that lets in.
    pub fn unauthorized(detail: &str) -> Self {
        let mut refused = Self::from(Problem::new(401, "unauthorized", "Unauthorized", detail));
        let challenge = HeaderValue::from_static("Bearer realm=\"graspd\"");
        refused.headers.push((WWW_AUTHENTICATE, challenge));
        refused
    }

    /// 429: a rate or a quota is used up.
    pub fn too_many(detail: impl Into<String>, standing: Standing) -> Self {
        let problem = Problem::new(429, standing.name, "Too many requests", detail);
        let mut refused = Self::from(problem).retry_after(standing.reset_s);
        refused.headers.extend(standing.headers());
        refused
    }

    /// 404: nothing here, or not for this client.
    pub fn not_found() -> Self {
        framework(StatusCode::NOT_FOUND).into()
    }

    /// 406: the client accepts none of `offered`.
    pub fn not_acceptable(offered: &str) -> Self {
        Problem::new(
            406,
            "not-acceptable",
            "Not acceptable",
            format!("this resource is served as {offered}; accept that or */*"),
        )
        .into()
    }

    /// 408: the body came too slowly.
    pub fn too_slow() -> Self {
        framework(StatusCode::REQUEST_TIMEOUT).into()
    }

    /// 409: not in the state that the request needs.
    pub fn conflict(detail: impl Into<String>) -> Self {
        Problem::new(409, "conflict", "Conflict", detail).into()
    }

    /// 410: it was here.
    pub fn gone(detail: impl Into<String>) -> Self {
        Problem::new(410, "gone", "Gone", detail).into()
    }

    /// 413: more bytes or parts than are taken.
    pub fn too_large(detail: impl Into<String>) -> Self {
        Problem::new(413, "too-large", "Content too large", detail).into()
    }

    /// 414: the address is too long.
    pub fn uri_too_long() -> Self {
        framework(StatusCode::URI_TOO_LONG).into()
    }

    /// 415: the body is of a kind that is not read here.
    pub fn unsupported(detail: impl Into<String>) -> Self {
        Problem::new(
            415,
            "unsupported-media-type",
            "Unsupported media type",
            detail,
        )
        .into()
    }

    /// 422: fields are unknown, of the wrong type, out of range or at odds with each other.
    pub fn invalid(errors: Vec<FieldError>) -> Self {
        Problem::invalid(errors).into()
    }

    /// 422 for one field.
    pub fn invalid_field(pointer: &str, detail: impl Into<String>) -> Self {
        Self::invalid(vec![FieldError {
            pointer: pointer.to_owned(),
            detail: detail.into(),
        }])
    }

    /// 431: too many headers, or too long.
    pub fn headers_too_large() -> Self {
        framework(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE).into()
    }

    /// As `status` says: the head of the request cannot be read.
    pub fn unread(status: StatusCode) -> Self {
        framework(status).into()
    }

    /// 501: the body is in a transfer coding that is not read here.
    pub fn unknown_coding() -> Self {
        Problem::new(
            501,
            "unknown-transfer-coding",
            "Not implemented",
            "chunked is the only transfer coding that is read here",
        )
        .into()
    }

    /// 503: the address of the peer has its share of the connections.
    pub fn crowded() -> Self {
        Self::unavailable(
            "crowded",
            "this address has as many connections open as one may have; close some, or send more \
             requests over each",
            1,
        )
    }

    /// 503: cannot take it now.
    pub fn unavailable(kind: &str, detail: impl Into<String>, retry_after_s: u64) -> Self {
        Self::from(Problem::new(503, kind, "Unavailable", detail)).retry_after(retry_after_s)
    }

    /// 507: no room on the disk.
    pub fn disk_full() -> Self {
        Problem::new(
            507,
            "disk-full",
            "Insufficient storage",
            "the server's disk is full; reading still works, and cancelling as far as the room kept for it goes",
        )
        .into()
    }

    /// 500: a bug. `cause` goes to the log under the id that the client gets.
    pub fn internal(cause: impl std::fmt::Display) -> Self {
        let incident = uuid::Uuid::new_v4();
        let cause = cause.to_string();
        tracing::error!(%incident, cause, "internal error");
        Problem::new(
            500,
            "internal-error",
            "Internal error",
            format!("a fault of the server; its log tells more under the id {incident}"),
        )
        .into()
    }

    /// Adds a Retry-After header.
    pub fn retry_after(mut self, seconds: u64) -> Self {
        self.headers.push((RETRY_AFTER, seconds.into()));
        self
    }

    /// What the body of the answer says.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The whole answer in bytes, where there is no request to answer and the connection ends.
    pub fn on_the_wire(&self) -> Vec<u8> {
        let Problem { status, title, .. } = &*self.problem;
        let body = serde_json::to_vec(&self.problem).unwrap_or_default();
        let headers: String = self
            .headers
            .iter()
            .filter_map(|(name, value)| Some(format!("{name}: {}\r\n", value.to_str().ok()?)))
            .collect();
        let date = DateTimePrinter::new()
            .timestamp_to_rfc9110_string(&Timestamp::now())
            .unwrap_or_default();
        let head = format!(
            "HTTP/1.1 {status} {title}\r\ncontent-type: {PROBLEM_JSON}\r\n\
             content-length: {}\r\nconnection: close\r\nx-content-type-options: nosniff\r\n\
             cache-control: no-cache\r\n{headers}date: {date}\r\n\r\n",
            body.len()
        );
        [head.as_bytes(), &body].concat()
    }
}

/// The kind of problem that a response is, for those that it passes on its way out.
#[derive(Debug, Clone)]
pub struct Refusal(pub String);

impl From<Problem> for Error {
    fn from(problem: Problem) -> Self {
        Self {
            problem: Box::new(problem),
            headers: Vec::new(),
        }
    }
}

impl From<jobs::Error> for Error {
    fn from(error: jobs::Error) -> Self {
        match error {
            jobs::Error::NotFound => Self::not_found(),
            jobs::Error::Gone => Problem::new(
                410,
                "gone",
                "Gone",
                "this was here and has expired, or has been deleted; submit it again, under another \
                 Idempotency-Key",
            )
            .into(),
            jobs::Error::KeyRevoked => Self::unauthorized("this API key was revoked or has expired"),
            jobs::Error::InFlight => Self::conflict(
                "a submission under this Idempotency-Key is under way; send it again in a moment",
            )
            .retry_after(1),
            jobs::Error::KeyReused => Problem::new(
                422,
                "idempotency-key-reused",
                "Idempotency-Key used before",
                "another request was submitted under this Idempotency-Key in the last 24 hours; use a new \
                 key for a new request",
            )
            .into(),
            jobs::Error::QueueQuotaUsed {
                share,
                retry_after_s,
            } => Self::too_many(
                format!("{share} jobs of this key wait, and no more may; try again later"),
                quota("queued-jobs", share.into(), retry_after_s),
            ),
            jobs::Error::MeshQuotaUsed { room } => Self::too_many(
                format!(
                    "the meshes of this key may have {room} bytes in all; delete some, or wait until they expire"
                ),
                quota("mesh-bytes", room, ROOM_RETRY_AFTER_S),
            ),
            jobs::Error::MeshInUse => Self::conflict(
                "a queued or running job uses this mesh; cancel that job or wait for its end",
            ),
            jobs::Error::InvalidCursor => {
                Self::query("cursor", "not a next_cursor that this list has answered")
            }
            jobs::Error::UnknownMesh => {
                Self::invalid_field("/mesh_id", "no such mesh; upload it with POST /meshes")
            }
            jobs::Error::QueueFull { retry_after_s } => {
                let detail = "as many jobs wait as may; try again later";
                Self::unavailable("queue-full", detail, retry_after_s)
            }
            jobs::Error::Draining => Self::unavailable(
                "draining",
                "the server is shutting down; try again later",
                RETRY_AFTER_S,
            ),
            jobs::Error::WorkerLost => Self::unavailable(
                "worker-lost",
                "a worker of the server is gone; it has to be restarted",
                RETRY_AFTER_S,
            ),
            jobs::Error::OutOfMemory => Self::unavailable(
                "out-of-memory",
                "the server is at the limit of its memory; try again later",
                RETRY_AFTER_S,
            ),
            jobs::Error::TooManyFollowers => Self::unavailable(
                "too-many-followers",
                "as many clients wait for news of jobs as may; read the job without wait, or try again later",
                RETRY_AFTER_S,
            ),
            jobs::Error::Unready { kind, detail } => Self::unavailable(kind, detail, RETRY_AFTER_S),
            jobs::Error::Refused(problem) => problem.into(),
            jobs::Error::Store(fault) => fault.into(),
            jobs::Error::Bug(cause) => Self::internal(cause),
        }
    }
}

/// A quota that is used up.
fn quota(name: &'static str, limit: u64, reset_s: u64) -> Standing {
    Standing {
        name,
        limit,
        left: 0,
        window_s: None,
        reset_s,
    }
}

impl From<StoreError> for Error {
    fn from(fault: StoreError) -> Self {
        tracing::error!(%fault, "the store refuses");
        match fault {
            StoreError::Full => Self::disk_full(),
            _ => Self::unavailable(
                "store-unavailable",
                "the store is out of reach; try again later",
                RETRY_AFTER_S,
            ),
        }
    }
}

impl IntoResponse for Error {
    fn into_response(self) -> Response {
        let status =
            StatusCode::from_u16(self.problem.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let body = serde_json::to_vec(&self.problem).unwrap_or_default();
        let mut response = (status, [(CONTENT_TYPE, PROBLEM_JSON)], body).into_response();
        let kind = self.problem.kind.rsplit('/').next().unwrap_or_default();
        response.extensions_mut().insert(Refusal(kind.to_owned()));
        response.headers_mut().extend(self.headers);
        response
    }
}

/// Turns an error that the framework answered in its own words into a problem.
pub fn unify(response: Response) -> Response {
    let status = response.status();
    let is_error = status.is_client_error() || status.is_server_error();
    let is_problem = response
        .headers()
        .get(CONTENT_TYPE)
        .is_some_and(|kind| kind == PROBLEM_JSON);
    if !is_error || is_problem {
        return response;
    }
    let allow: Option<HeaderValue> = response.headers().get(ALLOW).cloned();
    let mut unified = Error::from(framework(status)).into_response();
    if let Some(allow) = allow {
        unified.headers_mut().insert(ALLOW, allow);
    }
    unified
}

/// What the framework's own refusals mean in the words of this service.
fn framework(status: StatusCode) -> Problem {
    let (kind, detail) = match status {
        StatusCode::NOT_FOUND => (
            "not-found",
            "nothing is here under this name; /openapi.json lists what there is",
        ),
        StatusCode::METHOD_NOT_ALLOWED => (
            "method-not-allowed",
            "this resource does not know the method; the Allow header names those it knows",
        ),
        StatusCode::REQUEST_TIMEOUT => (
            "too-slow",
            "the body did not arrive in time; send it without long pauses",
        ),
        StatusCode::PAYLOAD_TOO_LARGE => ("too-large", "the body is longer than is taken here"),
        StatusCode::URI_TOO_LONG => ("uri-too-long", "an address may have at most 8192 bytes"),
        StatusCode::UNSUPPORTED_MEDIA_TYPE => (
            "unsupported-media-type",
            "the body is of a kind that is not read here",
        ),
        StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE => (
            "headers-too-large",
            "at most 100 headers with 16384 bytes altogether are taken",
        ),
        status if status.is_server_error() => ("internal-error", "a fault of the server"),
        _ => ("bad-request", "the request cannot be understood"),
    };
    let title = status.canonical_reason().unwrap_or("Error");
    Problem::new(status.as_u16(), kind, title, detail)
}
