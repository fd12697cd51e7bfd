//! The service itself: landing page, liveness, readiness.

use axum::extract::State;
use axum::http::header::VARY;
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::Response;
use serde::Serialize;
use utoipa::ToSchema;

use super::error::Error;
use super::query::Parameters;
use super::{page, reply};
use crate::jobs::Service;

/// What the service is and where to go on.
#[derive(Serialize, ToSchema)]
pub struct Landing {
    /// `graspd`.
    name: &'static str,
    /// Version of the service.
    version: &'static str,
    /// What can be called.
    endpoints: &'static [&'static str],
}

/// The state of the service in a word.
#[derive(Serialize, ToSchema)]
pub struct Health {
    /// `ok`.
    status: &'static str,
}

const LANDING: Landing = Landing {
    name: "graspd",
    version: env!("CARGO_PKG_VERSION"),
    endpoints: &[
        "POST /jobs",
        "GET /jobs",
        "GET /jobs/{id}",
        "GET /jobs/{id}/result",
        "GET /jobs/{id}/events",
        "POST /jobs/{id}/cancel",
        "DELETE /jobs/{id}",
        "GET /jobs/{id}/grasp.png",
        "GET /jobs/{id}/grasp.svg",
        "GET /jobs/{id}/convergence.png",
        "GET /jobs/{id}/convergence.svg",
        "GET /jobs/{id}/grasp.glb",
        "GET /jobs/{id}/grasp.csv",
        "GET /jobs/{id}/grasp.isaac.yaml",
        "GET /jobs/{id}/grasp.moveit.json",
        "GET /jobs/{id}/convergence.csv",
        "POST /batches",
        "GET /batches",
        "GET /batches/{id}",
        "GET /batches/{id}/results",
        "POST /batches/{id}/cancel",
        "DELETE /batches/{id}",
        "POST /evaluations",
        "POST /meshes",
        "GET /meshes",
        "GET /meshes/{id}",
        "GET /meshes/{id}/file",
        "GET /meshes/{id}/preview.png",
        "GET /meshes/{id}/preview.svg",
        "DELETE /meshes/{id}",
        "GET /docs",
        "GET /openapi.json",
        "GET /healthz",
        "GET /readyz",
        "GET /metrics",
    ],
};

const OK: Health = Health { status: "ok" };

/// What this is and where to go on: a page for a browser, JSON for a program
#[utoipa::path(get, path = "/", tag = "service", responses(
    (status = 200, description = "The endpoints", content(
        (Landing = "application/json"), (String = "text/html"))),
    (status = 400, description = "No query parameter is taken"),
    (status = 406, description = "Neither HTML nor JSON is accepted"),
))]
pub async fn landing(query: Parameters, headers: HeaderMap) -> Result<Response, Error> {
    query.only(&[])?;
    // Who takes either equally, such as a program that does not say, gets JSON.
    let wants_page =
        reply::weight(&headers, "text/html") > reply::weight(&headers, "application/json");
    if !wants_page && !reply::accepts(&headers, "application/json") {
        return Err(Error::not_acceptable("text/html or application/json"));
    }
    let (mut response, vary) = match wants_page {
        true => (page::index(&headers), "accept, accept-encoding"),
        false => (reply::json(StatusCode::OK, &LANDING)?, "accept"),
    };
    let vary = HeaderValue::from_static(vary);
    response.headers_mut().insert(VARY, vary);
    Ok(response)
}

/// Whether the process lives
#[utoipa::path(get, path = "/healthz", tag = "service", responses(
    (status = 200, description = "It lives", body = Health),
    (status = 400, description = "No query parameter is taken"),
))]
pub async fn healthz(query: Parameters) -> Result<Response, Error> {
    query.only(&[])?;
    reply::json(StatusCode::OK, &OK)
}

/// Whether the service takes new work
#[utoipa::path(get, path = "/readyz", tag = "service", responses(
    (status = 200, description = "It does", body = Health),
    (status = 400, description = "No query parameter is taken"),
    (status = 503, description = "It does not, for the cause that the problem names: it is shutting down, a worker is gone, its store cannot be read or written, or its disk is full or nearly so"),
))]
pub async fn readyz(State(service): State<Service>, query: Parameters) -> Result<Response, Error> {
    query.only(&[])?;
    service.ready().await?;
    reply::json(StatusCode::OK, &OK)
}
