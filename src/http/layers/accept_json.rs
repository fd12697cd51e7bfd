//! Routes that answer in JSON refuse, before they do anything, a client that does not accept it.

use axum::extract::Request;
use axum::http::Method;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::http::request::accept;

/// Refuses with 406 a request whose client does not accept JSON.
pub async fn check(request: Request, next: Next) -> Response {
    // The answer to a DELETE has no body, which anyone can accept.
    if request.method() == Method::DELETE {
        return next.run(request).await;
    }
    match accept::require(request.headers(), "application/json") {
        Ok(()) => next.run(request).await,
        Err(refused) => refused.into_response(),
    }
}
