//! The id of a request, and its line in the log.

use std::time::Instant;

use axum::extract::Request;
use axum::http::{HeaderName, HeaderValue};
use axum::middleware::Next;
use axum::response::Response;
use tracing::Instrument;

/// Names the request in the log; every response of the routes carries it.
pub const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Gives the request an id, opens its span, and logs the status and the time that it took.
///
/// The id that a client sends is kept when it is fit for a log.
pub async fn log(request: Request, next: Next) -> Response {
    let id = request
        .headers()
        .get(REQUEST_ID)
        .filter(|value| is_plain(value))
        .cloned()
        .or_else(|| HeaderValue::try_from(uuid::Uuid::now_v7().to_string()).ok())
        .unwrap_or_else(|| HeaderValue::from_static("none"));
    let span = tracing::info_span!(
        "request",
        request_id = id.to_str().unwrap_or_default(),
        method = %request.method(),
        path = request.uri().path(),
    );
    #[cfg(feature = "otel")]
    crate::otel::adopt(&span, request.headers());
    let start = Instant::now();
    async {
        let mut response = next.run(request).await;
        tracing::info!(
            status = response.status().as_u16(),
            milliseconds = start.elapsed().as_secs_f64() * 1e3,
            "answered"
        );
        response.headers_mut().insert(REQUEST_ID, id);
        response
    }
    .instrument(span)
    .await
}

fn is_plain(value: &HeaderValue) -> bool {
    (1..=128).contains(&value.len())
        && value
            .as_bytes()
            .iter()
            .all(|byte| byte.is_ascii_alphanumeric() || b"-_.:".contains(byte))
}
