//! The problem that a status alone stands for.

use axum::http::StatusCode;

use crate::wire::Problem;

/// Returns what axum and hyper mean by a status, in the words of this service.
pub fn problem_of_status(status: StatusCode) -> Problem {
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
