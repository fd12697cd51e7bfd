//! Uploads meshes.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;

use crate::http::app::App;
use crate::http::layers::auth::Caller;
use crate::http::openapi::bodies::{Binary, MeshForm};
use crate::http::request::form::{self, MeshFile};
use crate::http::request::media_type;
use crate::http::request::query::{Param, component, number, query};
use crate::http::response::error::Error;
use crate::http::response::json;
use crate::jobs::MeshUpload;
use crate::wire::json::MAX_JSON_BYTES;
use crate::wire::{MeshOptions, MeshRecord, Units, text};
use graspd_mesh_io::MeshFormat;

const FORMAT: Param<MeshFormat> = Param {
    name: "format",
    description: "MeshFormat of the file; else it is recognised by its media type, name or content",
    expected: MeshFormat::NAMES,
    parse: MeshFormat::from_name,
    schema: || component("MeshFormat"),
};

const UNITS: Param<Units> = Param {
    name: "units",
    description: "Unit of the coordinates once they are scaled",
    expected: Units::NAMES,
    parse: Units::named,
    schema: || component("Units"),
};

const SCALE: Param<f64> = Param {
    name: "scale",
    description: "Factor by which the coordinates of the file are multiplied; default 1",
    expected: MeshOptions::SCALES,
    parse: MeshOptions::scale_of,
    schema: || number(1e-9, 1e9),
};

query! {
    /// How an uploaded file is read.
    pub struct UploadQuery { format: MeshFormat = FORMAT, units: Units = UNITS, scale: f64 = SCALE }
}

/// Upload a mesh
///
/// As the part `mesh` of a multipart form, or as the raw body with its media type or with
/// `?format=`. The mesh is read and checked before the answer; the same file again, in the same unit and
/// scale, gives the same id.
#[utoipa::path(
    post, path = "/meshes", params(UploadQuery),
    request_body(content((MeshForm = "multipart/form-data"), (Binary = "application/octet-stream"), (Binary = "model/stl"), (Binary = "model/obj"), (Binary = "model/ply"), (Binary = "model/vnd.off"), (Binary = "model/gltf-binary"), (Binary = "model/gltf+json"), (Binary = "model/3mf"), (Binary = "model/vnd.collada+xml"))),
    responses(
        (status = 201, description = "Stored", body = MeshRecord),
        (status = 200, description = "It was stored already", body = MeshRecord),
        (status = 400, description = "The form is broken, or has no file or two"),
        (status = 415, description = "No mesh in a supported format"),
        (status = 422, description = "A mesh that cannot be used; errors say why"),
        (status = 503, description = "Shutting down, or the store is out of reach"),
    ),
)]
pub async fn upload_mesh(
    State(app): State<App>,
    Caller(owner): Caller,
    query: UploadQuery,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Error> {
    let named_format = query.format;
    let mut options = MeshOptions {
        format: None,
        units: query.units,
        scale: query.scale.unwrap_or(1.0),
    };
    let file = match media_type::of_body(&headers)?.as_deref() {
        Some("multipart/form-data") => {
            let form = form::read(&app, request, MAX_JSON_BYTES).await?;
            mesh_only(form, &mut options)?
        }
        kind => {
            let named = kind.and_then(MeshFormat::from_media_type);
            if named_format.is_none() && named.is_none() && kind != Some("application/octet-stream")
            {
                let types = MeshFormat::ALL.map(MeshFormat::media_type).join(", ");
                return Err(Error::unsupported(format!(
                    "send the mesh as multipart/form-data, {types} or application/octet-stream, or name its format \
                     with ?format="
                )));
            }
            options.format = named;
            form::read_raw(&app, request, named).await?
        }
    };
    options.format = named_format.or(options.format);
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
    let mut response = json::json(status, &mesh)?;
    json::set_location(&mut response, format!("/meshes/{}", mesh.id));
    Ok(response)
}

/// Returns the file of a form, and puts the `format`, `units` and `scale` of the form into `options`.
fn mesh_only(mut form: form::Form, options: &mut MeshOptions) -> Result<MeshFile, Error> {
    let given = form.take_options()?;
    options.format = given.format;
    if given.scale != 1.0 {
        options.scale = given.scale;
    }
    if let Some(at) = form.fields.iter().position(|(name, _)| name == "units") {
        let (_, name) = form.fields.remove(at);
        let units = Units::named(&name);
        let detail = || format!("must be {}", Units::NAMES);
        let units = units.ok_or_else(|| Error::invalid_field("/units", detail()))?;
        options.units = Some(units);
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
