//! What a mesh looks like.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::header::{CONTENT_TYPE, ETAG};
use axum::response::{IntoResponse, Response};
use utoipa::ToSchema;

use super::access::Caller;
use super::error::Error;
use super::openapi::Binary;
use super::query::{Name, Parameters};
use super::{App, reply};
use crate::core::mesh::Mesh;
use crate::picture::{self, Background, MAX_WIDTH, MIN_WIDTH, Options, PictureError};
use crate::wire::Units;

/// Draw a mesh
///
/// Two opposite views, side by side: from the front (−y), right and above, and from the back, left and
/// below. Border edges are red, non-manifold ones magenta, the inside of the surface is bluish, and the disc
/// in black and white quarters is the centre of mass.
#[utoipa::path(
    get, path = "/meshes/{id}/preview.png",
    operation_id = "preview_mesh", tag = "meshes",
    params(
        ("id" = String, Path, description = "Id of the mesh"),
        ("width" = Option<u32>, Query, minimum = 64, maximum = 4096, description = "Width in pixels; default 1024. The height is half of it"),
        ("theme" = inline(Option<Theme>), Query, description = "Background; default `light`"),
    ),
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
    let file = File {
        kind: "image/png",
        // Opaque, since nobody knows what it is shown on.
        background: Background::Light,
    };
    let draw =
        |mesh: &Mesh, _: Option<Units>, _: &str, options: &Options| picture::preview(mesh, options);
    answer(&app, &caller, &id, query, &headers, &file, draw).await
}

/// Draw a mesh with its report
///
/// The picture of `preview.png` above the figures of the report, as SVG. Without a theme it is light or
/// dark as the reader prefers.
#[utoipa::path(
    get, path = "/meshes/{id}/preview.svg",
    operation_id = "preview_mesh_report", tag = "meshes",
    params(
        ("id" = String, Path, description = "Id of the mesh"),
        ("width" = Option<u32>, Query, minimum = 64, maximum = 4096, description = "Width in pixels of the picture inside; default 1024"),
        ("theme" = inline(Option<Theme>), Query, description = "Colours; default is what the reader prefers"),
    ),
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
    let file = File {
        kind: "image/svg+xml",
        background: Background::Transparent,
    };
    let draw = picture::sheet;
    answer(&app, &caller, &id, query, &headers, &file, draw).await
}

/// What a picture is shown on.
#[derive(ToSchema)]
#[schema(rename_all = "lowercase")]
#[allow(
    dead_code,
    reason = "only described; the query is read as a Background"
)]
pub enum Theme {
    Light,
    Dark,
}

/// What is served.
struct File {
    kind: &'static str,
    /// Without a theme.
    background: Background,
}

async fn answer<T: IntoResponse + Send + 'static>(
    app: &App,
    Caller(owner): &Caller,
    id: &str,
    query: Parameters,
    headers: &HeaderMap,
    file: &File,
    draw: impl FnOnce(&Mesh, Option<Units>, &str, &Options) -> Result<T, PictureError> + Send + 'static,
) -> Result<Response, Error> {
    if !reply::accepts(headers, file.kind) {
        return Err(Error::not_acceptable(file.kind));
    }
    let options = options(query, file.background)?;
    let mesh = app.service.mesh(owner, id).await?;
    let Options { width, background } = options;
    // The same mesh is drawn to the same bytes by the same program.
    let tag = format!(
        "\"{}-{width}-{background:?}-{}\"",
        &mesh.id.as_str()[..32],
        env!("CARGO_PKG_VERSION")
    );
    if let Some(unchanged) = reply::not_modified(headers, &tag) {
        return Ok(unchanged);
    }
    let units = mesh.units;
    let title = mesh.file_name.unwrap_or_else(|| mesh.id.to_string());
    let drawn = app.service.draw(
        owner,
        id,
        u64::from(width) * u64::from(width) / 2,
        move |mesh| draw(mesh, units, &title, &options),
    );
    let bytes = drawn.await?.map_err(Error::internal)?;
    Ok(([(ETAG, tag.as_str()), (CONTENT_TYPE, file.kind)], bytes).into_response())
}

/// Width and theme of a picture, and no other parameter.
pub fn options(query: Parameters, background: Background) -> Result<Options, Error> {
    of_query(&query.only(&["width", "theme"])?, background)
}

/// Width and theme of a picture.
pub fn of_query(query: &Parameters, background: Background) -> Result<Options, Error> {
    let width = query.parse("width", "a whole number from 64 to 4096", |text| {
        let width = text.parse().ok()?;
        (MIN_WIDTH..=MAX_WIDTH).contains(&width).then_some(width)
    })?;
    let theme = query.parse("theme", "light or dark", |text| match text {
        "light" => Some(Background::Light),
        "dark" => Some(Background::Dark),
        _ => None,
    })?;
    Ok(Options {
        width: width.unwrap_or(picture::DEFAULT_WIDTH),
        background: theme.unwrap_or(background),
    })
}
