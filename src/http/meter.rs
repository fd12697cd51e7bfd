//! Numbers of requests taken, and the numbers of the service given out.

use std::time::Instant;

use axum::extract::{MatchedPath, Request, State};
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderMap, Method};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::error::{Error, Refusal};
use super::layers::Panicked;
use super::query::Parameters;
use super::reply;
use crate::jobs::Service;
use crate::metrics::{Format, Held};

/// What is no route: one name for all of it, or clients could make up names without end.
const NO_ROUTE: &str = "none";

/// Counts and times a request and its answer.
pub async fn measure(State(service): State<Service>, request: Request, next: Next) -> Response {
    let numbers = &service.metrics().http;
    let _in_flight = Held::new(&numbers.in_flight);
    let method = name(request.method());
    let route = request.extensions().get::<MatchedPath>().cloned();
    let start = Instant::now();
    let response = next.run(request).await;
    let route = route.as_ref().map_or(NO_ROUTE, MatchedPath::as_str);
    numbers.note(method, route, response.status().as_u16(), start.elapsed());
    if let Some(Refusal(kind)) = response.extensions().get() {
        numbers.reject(kind);
    }
    if response.extensions().get::<Panicked>().is_some() {
        numbers.panics.inc();
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

/// The numbers of the service for Prometheus
#[utoipa::path(get, path = "/metrics", tag = "service", responses(
    (status = 200, description = "The numbers, as the Prometheus text format or as OpenMetrics", content(
        (String = "text/plain"), (String = "application/openmetrics-text"))),
    (status = 400, description = "No query parameter is taken"),
    (status = 406, description = "Neither format is accepted"),
))]
pub async fn metrics(
    State(service): State<Service>,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    query.only(&[])?;
    let open = reply::weight(&headers, "application/openmetrics-text");
    let plain = reply::weight(&headers, "text/plain");
    let format = match open > plain {
        true => Format::OpenMetrics,
        false if plain > 0.0 => Format::Text,
        false => {
            return Err(Error::not_acceptable(
                "text/plain or application/openmetrics-text",
            ));
        }
    };
    let text = service.scrape(format).await.map_err(Error::internal)?;
    Ok(([(CONTENT_TYPE, format.content_type())], text).into_response())
}
