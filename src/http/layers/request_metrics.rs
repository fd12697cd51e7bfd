//! Counts and times every request.

use std::time::Instant;

use axum::extract::{MatchedPath, Request, State};
use axum::http::Method;
use axum::middleware::Next;
use axum::response::Response;

use super::panics::Panicked;
use crate::http::response::error::ProblemKind;
use crate::jobs::Service;
use crate::metrics::Held;

/// The label of all requests that match no route: with their paths, clients could make up labels without end.
const NO_ROUTE: &str = "none";

/// Counts a request and its answer by method, route and status, and measures the time between them.
pub async fn measure(State(service): State<Service>, request: Request, next: Next) -> Response {
    let metrics = &service.metrics().http;
    let _in_flight = Held::new(&metrics.in_flight);
    let method = name(request.method());
    let route = request.extensions().get::<MatchedPath>().cloned();
    let start = Instant::now();
    let response = next.run(request).await;
    let route = route.as_ref().map_or(NO_ROUTE, MatchedPath::as_str);
    metrics.note(method, route, response.status().as_u16(), start.elapsed());
    if let Some(ProblemKind(kind)) = response.extensions().get() {
        metrics.reject(kind);
    }
    if response.extensions().get::<Panicked>().is_some() {
        metrics.panics.inc();
    }
    response
}

fn name(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::HEAD => "HEAD",
        Method::POST => "POST",
        Method::PUT => "PUT",
        Method::PATCH => "PATCH",
        Method::DELETE => "DELETE",
        Method::OPTIONS => "OPTIONS",
        _ => "other",
    }
}
