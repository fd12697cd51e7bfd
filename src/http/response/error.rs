//! The error type of all handlers: a problem (RFC 9457) with the headers that its status calls for.

use axum::http::header::{CONTENT_TYPE, RETRY_AFTER, WWW_AUTHENTICATE};
use axum::http::{HeaderName, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use jiff::fmt::rfc2822::DateTimePrinter;

use super::status_problem::problem_of_status;
use crate::http::layers::rate_limit::RateLimitState;
use crate::wire::{FieldError, Problem, text};

/// Media type of every error.
pub const PROBLEM_JSON: &str = "application/problem+json";

/// A refused request: a [`Problem`] and the headers that its status calls for.
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

    /// 401: no API key, or one that is not valid.
    pub fn unauthorized(detail: &str) -> Self {
        let mut refused = Self::from(Problem::new(401, "unauthorized", "Unauthorized", detail));
        let challenge = HeaderValue::from_static("Bearer realm=\"graspd\"");
        refused.headers.push((WWW_AUTHENTICATE, challenge));
        refused
    }

    /// 429: a rate or a quota is used up.
    pub fn too_many(detail: impl Into<String>, state: RateLimitState) -> Self {
        let problem = Problem::new(429, state.name, "Too many requests", detail);
        let mut refused = Self::from(problem).retry_after(state.reset_s);
        refused.headers.extend(state.headers());
        refused
    }

    /// 404: there is nothing under this name, or not for this client.
    pub fn not_found() -> Self {
        problem_of_status(StatusCode::NOT_FOUND).into()
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
        problem_of_status(StatusCode::REQUEST_TIMEOUT).into()
    }

    /// 409: not in the state that the request needs.
    pub fn conflict(detail: impl Into<String>) -> Self {
        Problem::new(409, "conflict", "Conflict", detail).into()
    }

    /// 410: it existed and has expired or was deleted.
    pub fn gone(detail: impl Into<String>) -> Self {
        Problem::new(410, "gone", "Gone", detail).into()
    }

    /// 413: more bytes or parts than the limit.
    pub fn too_large(detail: impl Into<String>) -> Self {
        Problem::new(413, "too-large", "Content too large", detail).into()
    }

    /// 414: the address is too long.
    pub fn uri_too_long() -> Self {
        problem_of_status(StatusCode::URI_TOO_LONG).into()
    }

    /// 415: the body has a media type that the route does not read.
    pub fn unsupported(detail: impl Into<String>) -> Self {
        Problem::new(
            415,
            "unsupported-media-type",
            "Unsupported media type",
            detail,
        )
        .into()
    }

    /// 422: fields are unknown, of the wrong type, out of range or contradict each other.
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
        problem_of_status(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE).into()
    }

    /// `status`: hyper could not read the head of the request.
    pub fn unreadable_head(status: StatusCode) -> Self {
        problem_of_status(status).into()
    }

    /// 501: the body has a transfer coding other than chunked.
    pub fn unknown_coding() -> Self {
        Problem::new(
            501,
            "unknown-transfer-coding",
            "Not implemented",
            "chunked is the only transfer coding that this service reads",
        )
        .into()
    }

    /// 503: the network of the peer has as many connections open as it may.
    pub fn too_many_connections() -> Self {
        Self::unavailable(
            "crowded",
            "this address has as many connections open as one may have; close some, or send more \
             requests over each",
            1,
        )
    }

    /// 503: the request cannot be served now.
    pub fn unavailable(kind: &str, detail: impl Into<String>, retry_after_s: u64) -> Self {
        Self::from(Problem::new(503, kind, "Unavailable", detail)).retry_after(retry_after_s)
    }

    /// 507: the disk is full.
    pub fn disk_full() -> Self {
        Problem::new(
            507,
            "disk-full",
            "Insufficient storage",
            "the server's disk is full; reading still works, and cancelling as far as the room kept for it goes",
        )
        .into()
    }

    /// 500: a bug. `cause` goes to the log with an id, and the client gets the id alone.
    pub fn internal(cause: impl std::fmt::Display) -> Self {
        let incident = uuid::Uuid::new_v4();
        let cause = cause.to_string();
        tracing::error!(%incident, cause, "internal error");
        Problem::new(
            500,
            "internal-error",
            "Internal error",
            fault_detail(&incident),
        )
        .into()
    }

    /// Adds a Retry-After header.
    pub fn retry_after(mut self, seconds: u64) -> Self {
        self.headers.push((RETRY_AFTER, seconds.into()));
        self
    }

    /// Returns the problem that the body will say.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Returns the whole response in bytes, for a connection that ends without a readable request.
    pub fn to_raw_response(&self) -> Vec<u8> {
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

/// The kind of problem that a response carries, for the layers that it passes on its way out.
#[derive(Debug, Clone)]
pub struct ProblemKind(pub String);

impl From<Problem> for Error {
    fn from(problem: Problem) -> Self {
        Self {
            problem: Box::new(problem),
            headers: Vec::new(),
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
        response
            .extensions_mut()
            .insert(ProblemKind(kind.to_owned()));
        response.headers_mut().extend(self.headers);
        response
    }
}

/// Returns the detail of a 500 under the id of its line in the log.
pub fn fault_detail(incident: &impl std::fmt::Display) -> String {
    format!("a fault of the server; its log has the cause under the id {incident}")
}
