//! Lists, reads and deletes meshes.

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::request::query::{DEFAULT_LIMIT, Name, NoQuery, PageQuery};
use crate::http::response::conditional;
use crate::http::response::error::Error;
use crate::http::response::json;
use crate::wire::{MeshPage, MeshRecord};

/// List meshes, newest first
#[utoipa::path(
    get, path = "/meshes", params(PageQuery),
    responses((status = 200, description = "One page", body = MeshPage)),
)]
pub async fn list_meshes(
    State(app): State<App>,
    Caller(owner): Caller,
    query: PageQuery,
) -> Result<Response, Error> {
    let limit = query.limit.unwrap_or(DEFAULT_LIMIT);
    let page = app.service.meshes(&owner, limit, query.cursor.as_deref());
    json::json(StatusCode::OK, &page.await?)
}

/// Read the report of a mesh
#[utoipa::path(
    get, path = "/meshes/{id}",
    responses((status = 200, description = "The report", body = MeshRecord,
        headers(("ETag" = String, description = "Changes with the report")))),
)]
pub async fn read_mesh(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    _: NoQuery,
    headers: HeaderMap,
) -> Result<Response, Error> {
    conditional::hashed_json(&headers, &app.service.mesh(&owner, &id).await?)
}

/// Forget a mesh
#[utoipa::path(
    delete, path = "/meshes/{id}",
    responses(
        (status = 204, description = "Forgotten"),
        (status = 409, description = "A job uses it"),
    ),
)]
pub async fn delete_mesh(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    _: NoQuery,
) -> Result<Response, Error> {
    app.service.delete_mesh(&owner, &id).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}
