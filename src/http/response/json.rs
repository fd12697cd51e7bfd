//! Responses whose body is JSON, and the headers of those that announce work under way.

use axum::http::header::{CONTENT_TYPE, LOCATION, RETRY_AFTER};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use super::error::Error;

/// Seconds after which another look at unfinished work is worth a request.
pub const POLL_S: u64 = 1;

/// Returns a JSON body.
pub fn json(status: StatusCode, value: &impl Serialize) -> Result<Response, Error> {
    let body = serde_json::to_vec(value).map_err(Error::internal)?;
    Ok((status, [(CONTENT_TYPE, "application/json")], body).into_response())
}

/// Sets Location to the address of what was made.
pub fn set_location(response: &mut Response, path: String) {
    if let Ok(path) = HeaderValue::try_from(path) {
        response.headers_mut().insert(LOCATION, path);
    }
}

/// Sets Retry-After to when unfinished work is worth another look.
pub fn set_retry_after(response: &mut Response) {
    response
        .headers_mut()
        .insert(RETRY_AFTER, HeaderValue::from(POLL_S));
}
