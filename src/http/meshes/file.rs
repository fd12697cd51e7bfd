//! Meshes as files of other formats.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;

use crate::export::{self, EXPORT_FORMATS, ExportFormat, MAX_BUDGET, MIN_BUDGET};
use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::openapi::bodies::Binary;
use crate::http::request::accept;
use crate::http::request::query::{Name, Param, one_of, query, whole_number};
use crate::http::response::conditional::{self, FileHead};
use crate::http::response::error::Error;

const FORMAT: Param<&'static ExportFormat> = Param {
    name: "format",
    description: "Format of the file; default `glb`",
    expected: ExportFormat::NAMES,
    parse: ExportFormat::named,
    schema: || one_of(&EXPORT_FORMATS.each_ref().map(|format| format.name)),
};

const MAX_TRIANGLES: Param<usize> = Param {
    name: "max_triangles",
    description: "Most triangles of the file; all if absent",
    expected: "a whole number from 1000 to 2000000",
    parse: |text| {
        let budget = text.parse().ok()?;
        (MIN_BUDGET..=MAX_BUDGET)
            .contains(&budget)
            .then_some(budget)
    },
    schema: || whole_number(MIN_BUDGET as u32, MAX_BUDGET as u32),
};

query! {
    /// How a mesh is written.
    pub struct FileQuery {
        format: &'static ExportFormat = FORMAT,
        max_triangles: usize = MAX_TRIANGLES,
    }
}

/// Read a mesh as a file
///
/// The surface as prepared: welded, wound outwards. Coordinates are in the mesh's frame and unit. GLB is in metres: its
/// root node scales them where the unit is known, and `extras.triangles` of its primitive is the accessor of the
/// numbers that the triangles have in the uploaded file; the faces of a PLY have them too. With `max_triangles` a mesh
/// that has more is made coarser, to look at: every vertex is near the surface, and the numbers are of triangles that
/// were near.
#[utoipa::path(
    get, path = "/meshes/{id}/file", params(FileQuery),
    responses((status = 200, description = "The file",
        content((Binary = "model/gltf-binary"), (Binary = "model/stl"), (Binary = "model/ply")),
        headers(
            ("ETag" = String, description = "Changes with the file"),
            ("Content-Disposition" = String, description = "A name to save it under")))),
)]
pub async fn export_mesh(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: FileQuery,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let format = query.format.unwrap_or(&EXPORT_FORMATS[0]);
    accept::require(&headers, format.media_type)?;
    let mesh = app.service.mesh(&owner, &id).await?;
    let (name, ending) = (&mesh.id.as_str()[..32], format.name);
    let size = query
        .max_triangles
        .map_or_else(|| "all".to_owned(), |budget| budget.to_string());
    let head = FileHead {
        tag: format!("\"{name}-{ending}-{size}-{}\"", env!("CARGO_PKG_VERSION")),
        media_type: format.media_type,
        // The name of the uploaded file is its sender's, and may not fit into a header.
        name: Some(format!("mesh-{}.{ending}", &name[..8])),
    };
    let budget = query.max_triangles.unwrap_or(usize::MAX);
    let units = mesh.units;
    let write = move |mesh: &_| export::mesh(mesh, units, format, budget);
    let written = app.service.draw(&owner, &id, 0, write);
    conditional::file(&headers, head, async {
        written.await?.map_err(Error::internal)
    })
    .await
}
