//! The metrics of the service for Prometheus.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};

use crate::http::request::accept;
use crate::http::request::query::NoQuery;
use crate::http::response::error::Error;
use crate::jobs::Service;
use crate::metrics::Format;

/// The metrics of the service for Prometheus
#[utoipa::path(get, path = "/metrics", responses(
    (status = 200, description = "The metrics, as the Prometheus text format or as OpenMetrics", content(
        (String = "text/plain"), (String = "application/openmetrics-text"))),
))]
pub async fn metrics(
    State(service): State<Service>,
    _: NoQuery,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let open = accept::weight(&headers, "application/openmetrics-text");
    let plain = accept::weight(&headers, "text/plain");
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
