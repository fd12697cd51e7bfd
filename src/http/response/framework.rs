//! Errors that axum answers itself, such as an unknown path or a wrong method, become problems like
//! all others.

use axum::http::HeaderValue;
use axum::http::header::{ALLOW, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};

use super::error::{Error, PROBLEM_JSON};
use super::status_problem::problem_of_status;

/// Turns an error without a problem into one, keeping its status and its Allow header.
pub fn into_problem(response: Response) -> Response {
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
    let mut unified = Error::from(problem_of_status(status)).into_response();
    if let Some(allow) = allow {
        unified.headers_mut().insert(ALLOW, allow);
    }
    unified
}
