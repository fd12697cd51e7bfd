//! The landing page, liveness and readiness.

use std::sync::Arc;

use axum::extract::State;
use axum::http::header::VARY;
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::Response;
use serde::Serialize;
use utoipa::ToSchema;

use super::page;
use crate::http::app::App;
use crate::http::request::accept;
use crate::http::request::query::NoQuery;
use crate::http::response::error::Error;
use crate::http::response::json;
use crate::jobs::Service;

/// What the service is and where to go on.
#[derive(Serialize, ToSchema)]
pub struct Landing {
    /// `graspd`.
    name: &'static str,
    /// Version of the service.
    version: &'static str,
    /// All routes, each with its method.
    #[schema(value_type = Vec<String>)]
    endpoints: Arc<[String]>,
}

/// The state of the service in a word.
#[derive(Serialize, ToSchema)]
pub struct Health {
    /// `ok`.
    status: &'static str,
}

const OK: Health = Health { status: "ok" };

/// What this is and where to go on: a page for a browser, JSON for a program
#[utoipa::path(get, path = "/", responses(
    (status = 200, description = "The endpoints", content(
        (Landing = "application/json"), (String = "text/html"))),
    (status = 406, description = "The client accepts neither HTML nor JSON"),
))]
pub async fn landing(
    State(app): State<App>,
    _: NoQuery,
    headers: HeaderMap,
) -> Result<Response, Error> {
    // A client that accepts both equally, such as a program without an Accept header, gets JSON.
    let prefers_page =
        accept::weight(&headers, "text/html") > accept::weight(&headers, "application/json");
    if !prefers_page && !accept::accepts(&headers, "application/json") {
        return Err(Error::not_acceptable("text/html or application/json"));
    }
    let landing = Landing {
        name: "graspd",
        version: env!("CARGO_PKG_VERSION"),
        endpoints: app.endpoints,
    };
    let (mut response, vary) = match prefers_page {
        true => (page::index(&headers), "accept, accept-encoding"),
        false => (json::json(StatusCode::OK, &landing)?, "accept"),
    };
    let vary = HeaderValue::from_static(vary);
    response.headers_mut().insert(VARY, vary);
    Ok(response)
}

/// Whether the process is alive
#[utoipa::path(get, path = "/healthz", responses(
    (status = 200, description = "It is alive", body = Health),
))]
pub async fn healthz(_: NoQuery) -> Result<Response, Error> {
    json::json(StatusCode::OK, &OK)
}

/// Whether the service accepts new work
#[utoipa::path(get, path = "/readyz", responses(
    (status = 200, description = "It does", body = Health),
    (status = 503, description = "It does not, for the cause that the problem names: it is shutting down, a worker is gone, its store cannot be read or written, or its disk is full or nearly so"),
))]
pub async fn readyz(State(service): State<Service>, _: NoQuery) -> Result<Response, Error> {
    service.ready().await?;
    json::json(StatusCode::OK, &OK)
}
