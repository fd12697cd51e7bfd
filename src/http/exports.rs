//! Meshes as files of other formats.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use utoipa::ToSchema;

use super::access::Caller;
use super::error::Error;
use super::openapi::Binary;
use super::query::{Name, Parameters};
use super::{App, reply};
use crate::export::{self, ExportFormat, MAX_BUDGET, MIN_BUDGET};

/// Format of an exported mesh.
#[derive(ToSchema)]
#[schema(rename_all = "lowercase")]
#[allow(
    dead_code,
    reason = "only described; the query is read as a ExportFormat"
)]
enum Format {
    Glb,
    Stl,
    Ply,
}

/// Read a mesh as a file
///
/// The surface as prepared: welded, wound outwards. Coordinates are those of the mesh's frame and unit; in GLB, which
/// is in metres, the root node scales them where the unit is known, and `extras.triangles` of its primitive is the
/// accessor of the numbers that the triangles have in the uploaded file, as have the faces of a PLY. With
/// `max_triangles` a mesh that has more is made coarser, to look at: every vertex is near the surface, and the
/// numbers are of triangles that were near.
#[utoipa::path(
    get, path = "/meshes/{id}/file",
    operation_id = "export_mesh", tag = "meshes",
    params(
        ("id" = String, Path, description = "Id of the mesh"),
        ("format" = inline(Option<Format>), Query, description = "Format of the file; default `glb`"),
        ("max_triangles" = Option<u32>, Query, minimum = 1000, maximum = 2_000_000, description = "Most triangles of the file; all if absent"),
    ),
    responses(
        (status = 200, description = "The file", content((Binary = "model/gltf-binary"), (Binary = "model/stl"), (Binary = "model/ply")), headers(
            ("ETag" = String, description = "Changes with the file"),
            ("Content-Disposition" = String, description = "A name to keep it under"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such mesh"),
        (status = 406, description = "The format is not accepted"),
    ),
)]
pub async fn mesh(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let query = query.only(&["format", "max_triangles"])?;
    let format = query.parse("format", ExportFormat::NAMES, ExportFormat::named)?;
    let format = format.unwrap_or(ExportFormat::Glb);
    let wanted = format!("a whole number from {MIN_BUDGET} to {MAX_BUDGET}");
    let budget = query.parse("max_triangles", &wanted, |text| {
        let budget = text.parse().ok()?;
        (MIN_BUDGET..=MAX_BUDGET)
            .contains(&budget)
            .then_some(budget)
    })?;
    reply::accepted(&headers, format.media_type())?;
    let mesh = app.service.mesh(&owner, &id).await?;
    let (name, ending) = (&mesh.id.as_str()[..32], format.ending());
    let size = budget.map_or_else(|| "all".to_owned(), |budget: usize| budget.to_string());
    let tag = format!("\"{name}-{ending}-{size}-{}\"", env!("CARGO_PKG_VERSION"));
    if let Some(unchanged) = reply::not_modified(&headers, &tag) {
        return Ok(unchanged);
    }
    let units = mesh.units;
    let write = move |mesh: &_| export::mesh(mesh, units, format, budget.unwrap_or(usize::MAX));
    let file = app.service.draw(&owner, &id, 0, write).await?;
    let file = file.map_err(Error::internal)?;
    // The name of the uploaded file is its sender's, and not fit for a header.
    let name = format!("mesh-{}.{ending}", &name[..8]);
    reply::file(&tag, format.media_type(), Some(&name), file)
}
