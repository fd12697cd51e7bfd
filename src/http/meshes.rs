//! Meshes: upload, list, read, forget.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};

use super::access::Caller;
use super::error::Error;
use super::form::{self, MeshFile};
use super::openapi::{Binary, MeshForm};
use super::query::{Name, Parameters};
use super::{App, body, reply};
use crate::jobs::MeshUpload;
use crate::wire::json::MAX_JSON_BYTES;
use crate::wire::{MeshOptions, MeshPage, MeshRecord, Units, text};
use graspd_mesh_io::MeshFormat;

/// Upload a mesh
///
/// As the part `mesh` of a multipart form, or as the raw body with its media type or with
/// `?format=`. The mesh is read and checked before the answer; the same file again, in the same unit and
/// scale, gives the same id.
#[utoipa::path(
    post, path = "/meshes",
    operation_id = "upload_mesh", tag = "meshes",
    params(
        ("format" = Option<MeshFormat>, Query, description = "Format of the file; else its media type, name or content tells"),
        ("units" = Option<Units>, Query, description = "Unit of the coordinates once they are scaled"),
        ("scale" = Option<f64>, Query, minimum = 1e-9, maximum = 1e9, description = "What the coordinates of the file are multiplied by; default 1"),
    ),
    request_body(content((MeshForm = "multipart/form-data"), (Binary = "application/octet-stream"), (Binary = "model/stl"), (Binary = "model/obj"), (Binary = "model/ply"), (Binary = "model/vnd.off"), (Binary = "model/gltf-binary"), (Binary = "model/gltf+json"))),
    responses(
        (status = 201, description = "Kept", body = MeshRecord, headers(("Location" = String, description = "Where the mesh is"))),
        (status = 200, description = "It was here already", body = MeshRecord, headers(("Location" = String, description = "Where the mesh is"))),
        (status = 400, description = "The form is broken, or has no file or two"),
        (status = 406, description = "JSON is not accepted"),
        (status = 408, description = "The body came too slowly"),
        (status = 413, description = "Larger than the server takes"),
        (status = 415, description = "No mesh in a supported format"),
        (status = 422, description = "A mesh that cannot be used; errors say why"),
        (status = 503, description = "Shutting down, or the store is out of reach"),
        (status = 507, description = "The disk of the server is full"),
    ),
)]
pub async fn upload(
    State(app): State<App>,
    Caller(owner): Caller,
    query: Parameters,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Error> {
    let query = query.only(&["format", "units", "scale"])?;
    let wanted = query.parse("format", MeshFormat::NAMES, MeshFormat::from_name)?;
    let mut options = MeshOptions {
        format: None,
        units: query.parse("units", Units::NAMES, Units::named)?,
        scale: query
            .parse("scale", MeshOptions::SCALES, MeshOptions::scale_of)?
            .unwrap_or(1.0),
    };
    let file = match body::media_type(&headers)?.as_deref() {
        Some("multipart/form-data") => {
            let form = form::read(&app, request, MAX_JSON_BYTES).await?;
            mesh_only(form, &mut options)?
        }
        kind => {
            let named = kind.and_then(MeshFormat::from_media_type);
            if wanted.is_none() && named.is_none() && kind != Some("application/octet-stream") {
                return Err(Error::unsupported(
                    "send the mesh as multipart/form-data, model/stl, model/obj, model/ply, model/vnd.off, \
                     model/gltf-binary, model/gltf+json or application/octet-stream, or name its format \
                     with ?format=",
                ));
            }
            options.format = named;
            form::read_raw(&app, request, named).await?
        }
    };
    options.format = wanted.or(options.format);
    let incoming = MeshUpload {
        upload: file.upload,
        options,
        file_name: file.name,
    };
    let (mesh, created) = app.service.add_mesh(&owner, incoming).await?;
    let status = if created {
        StatusCode::CREATED
    } else {
        StatusCode::OK
    };
    let mut response = reply::json(status, &mesh)?;
    reply::locate(&mut response, format!("/meshes/{}", mesh.id));
    Ok(response)
}

/// The file of a form, in which `format`, `units` and `scale` may stand that the query does not have.
fn mesh_only(mut form: form::Form, options: &mut MeshOptions) -> Result<MeshFile, Error> {
    let given = form.take_options()?;
    options.format = given.format;
    if given.scale != 1.0 {
        options.scale = given.scale;
    }
    if let Some(at) = form.fields.iter().position(|(name, _)| name == "units") {
        let (_, name) = form.fields.remove(at);
        let units = Units::named(&name);
        let wanted = || Error::invalid_field("/units", format!("{} is wanted", Units::NAMES));
        options.units = Some(units.ok_or_else(wanted)?);
    }
    let stray = form.fields.first().map(|(name, _)| name.as_str());
    if let Some(name) = stray.or(form.request.is_some().then_some("request")) {
        return Err(Error::invalid_field(
            &text::pointer(name),
            "unknown field; a mesh upload has the part mesh, and may have format, units and scale",
        ));
    }
    form.file
        .ok_or_else(|| Error::bad_request("the form has no file; send the mesh as the part mesh"))
}

/// List meshes, newest first
#[utoipa::path(
    get, path = "/meshes",
    operation_id = "list_meshes", tag = "meshes",
    params(
        ("limit" = Option<u32>, Query, minimum = 1, maximum = 1000, description = "Most items of one page; default 50"),
        ("cursor" = Option<String>, Query, description = "Where the page before this one ended, as its `next_cursor` said"),
    ),
    responses(
        (status = 200, description = "One page", body = MeshPage),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 406, description = "JSON is not accepted"),
    ),
)]
pub async fn list(
    State(app): State<App>,
    Caller(owner): Caller,
    query: Parameters,
) -> Result<Response, Error> {
    let query = query.only(&["limit", "cursor"])?;
    let page = app
        .service
        .meshes(&owner, query.limit()?, query.get("cursor"))
        .await?;
    reply::json(StatusCode::OK, &page)
}

/// Read the report of a mesh
#[utoipa::path(
    get, path = "/meshes/{id}",
    operation_id = "read_mesh", tag = "meshes",
    params(("id" = String, Path, description = "Id of the mesh")),
    responses(
        (status = 200, description = "The report", body = MeshRecord, headers(("ETag" = String, description = "Changes with the report"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "No query parameter is taken"),
        (status = 404, description = "No such mesh"),
        (status = 406, description = "JSON is not accepted"),
    ),
)]
pub async fn read(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    query.only(&[])?;
    reply::tagged(&headers, &app.service.mesh(&owner, &id).await?)
}

/// Forget a mesh
#[utoipa::path(
    delete, path = "/meshes/{id}",
    operation_id = "delete_mesh", tag = "meshes",
    params(("id" = String, Path, description = "Id of the mesh")),
    responses(
        (status = 204, description = "Forgotten"),
        (status = 400, description = "No query parameter is taken"),
        (status = 404, description = "No such mesh"),
        (status = 409, description = "A job uses it"),
    ),
)]
pub async fn delete(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
) -> Result<Response, Error> {
    query.only(&[])?;
    app.service.delete_mesh(&owner, &id).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}
