//! What every request passes on its way in and every response on its way out.

use std::any::Any;
use std::time::Instant;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request};
use axum::http::header::{HOST, TRANSFER_ENCODING};
use axum::http::{HeaderName, HeaderValue, Method, Version};
use axum::middleware::{Next, from_fn, map_request, map_response};
use axum::response::{IntoResponse, Response};
use tower_http::catch_panic::CatchPanicLayer;
use tracing::Instrument;

use super::error::{self, Error};
use super::{body, policy, reply};

/// Names the request in the log; every answer of the routes carries it.
pub const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
const MAX_URI_BYTES: usize = 8 * 1024;
const MAX_HEADERS: usize = 100;
const MAX_HEADER_BYTES: usize = 16 * 1024;

/// Marks the answer to a request whose handling panicked.
#[derive(Debug, Clone, Copy)]
pub struct Panicked;

/// Wraps all routes and the answers to what is no route.
pub fn wrap(router: Router) -> Router {
    router
        .layer(CatchPanicLayer::custom(panicked))
        // Bodies are metered where they are read.
        .layer(DefaultBodyLimit::disable())
        .layer(map_response(async |response: Response| {
            error::unify(response)
        }))
        .layer(from_fn(limit_head))
        .layer(map_response(policy::secure))
        .layer(map_request(async |request| body::linger(request)))
        .layer(from_fn(observe))
        // For the layers themselves: a panic there must not take the connection either.
        .layer(CatchPanicLayer::custom(panicked))
}

/// Refuses, before anything is done, a request whose answer its client would not take.
pub async fn json_accepted(request: Request, next: Next) -> Response {
    let kind = "application/json";
    // What is deleted is answered without a body, which anyone can take.
    if request.method() == Method::DELETE || reply::accepts(request.headers(), kind) {
        next.run(request).await
    } else {
        Error::not_acceptable(kind).into_response()
    }
}

/// Gives the request an id, its own if it is fit to be logged, and logs how it went.
async fn observe(request: Request, next: Next) -> Response {
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

async fn limit_head(request: Request, next: Next) -> Response {
    let uri = request.uri();
    let uri_bytes = uri.path().len() + uri.query().map_or(0, |query| query.len() + 1);
    if uri_bytes > MAX_URI_BYTES {
        return Error::uri_too_long().into_response();
    }
    let headers = request.headers();
    let bytes: usize = headers
        .iter()
        .map(|(name, value)| name.as_str().len() + value.len() + ": \r\n".len())
        .sum();
    if headers.len() > MAX_HEADERS || bytes > MAX_HEADER_BYTES {
        return Error::headers_too_large().into_response();
    }
    let hosts = headers.get_all(HOST).iter().count();
    if hosts > 1 || (hosts == 0 && request.version() == Version::HTTP_11) {
        return Error::bad_request("an HTTP/1.1 request has one Host header").into_response();
    }
    let mut codings = headers.get_all(TRANSFER_ENCODING).iter();
    if let Some(coding) = codings.next()
        && (codings.next().is_some() || !coding.as_bytes().eq_ignore_ascii_case(b"chunked"))
    {
        return Error::unknown_coding().into_response();
    }
    next.run(request).await
}

fn panicked(cause: Box<dyn Any + Send>) -> Response {
    let words = cause
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| cause.downcast_ref::<&str>().copied())
        .unwrap_or("no words");
    let mut response = Error::internal(format_args!("panic: {words}")).into_response();
    response.extensions_mut().insert(Panicked);
    response
}

#[cfg(test)]
mod tests {
    use axum::body::Body;
    use axum::http::StatusCode;
    use axum::routing::get;
    use tower::ServiceExt;

    use super::*;

    #[tokio::test]
    async fn a_panic_is_a_problem_with_an_id_and_without_its_words() {
        async fn broken() -> &'static str {
            panic!("/a/secret/path")
        }
        let router = wrap(Router::new().route("/", get(broken)));
        let request = Request::get("/")
            .header("host", "x")
            .body(Body::empty())
            .unwrap();
        let answer = router.oneshot(request).await.unwrap();
        assert_eq!(answer.status(), StatusCode::INTERNAL_SERVER_ERROR);
        assert_eq!(answer.headers()["content-type"], error::PROBLEM_JSON);
        assert!(answer.headers().contains_key(REQUEST_ID));
        let body = axum::body::to_bytes(answer.into_body(), 10_000)
            .await
            .unwrap();
        let text = String::from_utf8(body.to_vec()).unwrap();
        assert!(
            text.contains("under the id") && !text.contains("secret"),
            "{text}"
        );
    }

    #[tokio::test]
    async fn a_refusal_in_the_framework_s_words_becomes_a_problem() {
        async fn refusing() -> (StatusCode, &'static str) {
            (StatusCode::UNPROCESSABLE_ENTITY, "in plain text")
        }
        let router = wrap(Router::new().route("/", get(refusing)));
        let request = Request::get("/")
            .header("host", "x")
            .body(Body::empty())
            .unwrap();
        let answer = router.oneshot(request).await.unwrap();
        assert_eq!(answer.status(), StatusCode::UNPROCESSABLE_ENTITY);
        assert_eq!(answer.headers()["content-type"], error::PROBLEM_JSON);
    }
}
