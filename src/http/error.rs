//! The one error type at the HTTP edge.

use axum::http::header::{ALLOW, CONTENT_TYPE, RETRY_AFTER};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};

use crate::jobs::{self, StoreError};
use crate::wire::{FieldError, Problem, text};

/// Media type of every error.
pub const PROBLEM_JSON: &str = "application/problem+json";

/// Seconds after which a client may try again when nothing better is known.
const RETRY_AFTER_S: u64 = 5;

/// A refused request: a [`Problem`] on its way out, with the headers its status asks for.
#[derive(Debug)]
pub struct Error {
    problem: Problem,
    retry_after_s: Option<u64>,
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
        Problem::new(
            422,
            "invalid-request",
            "Invalid request",
            "some fields cannot be used; see errors",
        )
        .with_errors(errors)
        .into()
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

    /// 503: cannot take it now.
    fn unavailable(kind: &str, detail: impl Into<String>, retry_after_s: u64) -> Self {
        Self::from(Problem::new(503, kind, "Unavailable", detail)).retry_after(retry_after_s)
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
        self.retry_after_s = Some(seconds);
        self
    }
}

/// The kind of problem that a response is, for those that it passes on its way out.
#[derive(Debug, Clone)]
pub struct Refusal(pub String);

impl From<Problem> for Error {
    fn from(problem: Problem) -> Self {
        Self {
            problem,
            retry_after_s: None,
        }
    }
}

impl From<jobs::Error> for Error {
    fn from(error: jobs::Error) -> Self {
        match error {
            jobs::Error::NotFound => Self::not_found(),
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
            jobs::Error::Unready { kind, detail } => Self::unavailable(kind, detail, RETRY_AFTER_S),
            jobs::Error::Refused(problem) => problem.into(),
            jobs::Error::Store(fault) => fault.into(),
            jobs::Error::Bug(cause) => Self::internal(cause),
        }
    }
}

impl From<StoreError> for Error {
    fn from(fault: StoreError) -> Self {
        tracing::error!(%fault, "the store refuses");
        match fault {
            StoreError::Full => Problem::new(
                507,
                "disk-full",
                "Insufficient storage",
                "the server's disk is full; reading and cancelling still work",
            )
            .into(),
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
        if let Some(seconds) = self.retry_after_s {
            response.headers_mut().insert(RETRY_AFTER, seconds.into());
        }
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
