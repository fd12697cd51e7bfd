//! The layers around all routes. The head of [`crate::http`] says in which order a request passes them, and why.

pub mod accept_json;
pub mod auth;
pub mod browser_policy;
pub mod client;
pub mod cors;
mod head_limits;
mod panics;
pub mod rate_limit;
pub mod request_log;
pub mod request_metrics;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware::{from_fn, map_request, map_response};
use axum::response::Response;

use super::request::lingering;
use super::response::framework;

/// Wraps all routes, and the answers to what is no route, in the layers that every request passes.
/// The last one added is the first that a request meets.
pub fn wrap(router: Router) -> Router {
    router
        .layer(panics::catch())
        // Each reader of a body sets a limit of its own.
        .layer(DefaultBodyLimit::disable())
        .layer(map_response(async |response: Response| {
            framework::into_problem(response)
        }))
        .layer(from_fn(head_limits::check))
        .layer(map_response(browser_policy::add_headers))
        .layer(map_request(async |request| lingering::linger(request)))
        .layer(from_fn(request_log::log))
        // For the layers themselves: a panic there must not break the connection either.
        .layer(panics::catch())
}

#[cfg(test)]
mod tests {
    use axum::body::Body;
    use axum::extract::Request;
    use axum::http::StatusCode;
    use axum::routing::get;
    use tower::ServiceExt;

    use super::request_log::REQUEST_ID;
    use super::*;
    use crate::http::response::error;

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
