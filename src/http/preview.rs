//! What a mesh looks like.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::{IntoResponse, Response};

use super::access::Caller;
use super::error::Error;
use super::openapi::Binary;
use super::picture_query::{self, Format, PictureParameters};
use super::query::{Name, Parameters};
use super::{App, reply};
use crate::picture::{self, Options, PictureError};
use crate::wire::Units;
use graspd_core::mesh::Mesh;
use graspd_mesh_io::MeshFormat;

/// Draw a mesh
///
/// Two opposite views, side by side, half as high as wide: from the front (−y), right and above, and from
/// the back, left and below. Border edges are red, non-manifold ones magenta, the inside of the surface is bluish, and the disc
/// in black and white quarters is the centre of mass.
#[utoipa::path(
    get, path = "/meshes/{id}/preview.png",
    operation_id = "preview_mesh", tag = "meshes",
    params(("id" = String, Path, description = "Id of the mesh"), PictureParameters),
    responses(
        (status = 200, description = "The picture", content((Binary = "image/png")), headers(("ETag" = String, description = "Changes with the picture"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such mesh"),
        (status = 406, description = "PNG is not accepted"),
    ),
)]
pub async fn png(
    State(app): State<App>,
    caller: Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let draw = |mesh: &Mesh, _: MeshFormat, _: Option<Units>, _: &str, options: &Options| {
        picture::preview(mesh, options)
    };
    answer(&app, &caller, &id, query, &headers, Format::Png, draw).await
}

/// Draw a mesh with its report
///
/// The picture of `preview.png` above the figures of the report, as SVG. Without a theme it is light or
/// dark as the reader prefers.
#[utoipa::path(
    get, path = "/meshes/{id}/preview.svg",
    operation_id = "preview_mesh_report", tag = "meshes",
    params(("id" = String, Path, description = "Id of the mesh"), PictureParameters),
    responses(
        (status = 200, description = "The picture and the figures", content((String = "image/svg+xml")), headers(("ETag" = String, description = "Changes with the picture"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such mesh"),
        (status = 406, description = "SVG is not accepted"),
    ),
)]
pub async fn svg(
    State(app): State<App>,
    caller: Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    answer(
        &app,
        &caller,
        &id,
        query,
        &headers,
        Format::Svg,
        picture::sheet,
    )
    .await
}

async fn answer<T: IntoResponse + Send + 'static>(
    app: &App,
    Caller(owner): &Caller,
    id: &str,
    query: Parameters,
    headers: &HeaderMap,
    format: Format,
    draw: impl FnOnce(&Mesh, MeshFormat, Option<Units>, &str, &Options) -> Result<T, PictureError>
    + Send
    + 'static,
) -> Result<Response, Error> {
    let options = picture_query::options(query, format)?;
    reply::accepted(headers, format.media_type())?;
    let mesh = app.service.mesh(owner, id).await?;
    let Options { width, background } = options;
    let (found, units) = (mesh.format, mesh.units);
    let title = mesh.file_name.unwrap_or_else(|| mesh.id.to_string());
    // The same mesh is drawn to the same bytes by the same program, under the same name.
    let name = reply::hash(format!("{title}\n{units:?}"));
    let tag = format!(
        "\"{}-{width}-{background:?}-{name}-{}\"",
        &mesh.id.as_str()[..32],
        env!("CARGO_PKG_VERSION")
    );
    if let Some(unchanged) = reply::not_modified(headers, &tag) {
        return Ok(unchanged);
    }
    let pixels = u64::from(width) * u64::from(width) / 2;
    let drawn = app.service.draw(owner, id, pixels, move |mesh| {
        draw(mesh, found, units, &title, &options)
    });
    let bytes = drawn.await?.map_err(Error::internal)?;
    reply::file(&tag, format.media_type(), None, bytes)
}
