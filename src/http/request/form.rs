//! Multipart forms: a mesh file and settings. And a mesh file as a raw body.

use axum::body::Body;
use axum::extract::multipart::{Field, MultipartError};
use axum::extract::{FromRequest, Multipart, Request};
use futures_util::{StreamExt, pin_mut};
use serde_json::Value;

use super::body::{self, BodyFault, ByteBudget};
use super::large::{LARGE_BYTES, LargeBodyPermit};
use super::{json_body, media_type};
use crate::http::app::App;
use crate::http::response::error::Error;
use crate::jobs::Upload;
use crate::wire::settings::FILE_SETTINGS;
use crate::wire::{MeshOptions, text};
use graspd_mesh_io::MeshFormat;

const MAX_PARTS: usize = 16;
const MAX_PART_HEADER_BYTES: usize = 8 * 1024;
/// Most of a body that the multipart parser may hold while it looks for the headers of a part. It is
/// handed pieces of up to 400 KiB, which may hold much more than those headers.
const MAX_HELD_BYTES: u64 = 1 << 20;
const MAX_NAME_BYTES: usize = 255;
/// Room for the parts beside the file, their headers and the boundaries.
const FORM_OVERHEAD_BYTES: u64 = 256 * 1024;

/// A form that was read to its end. The file is on disk and not yet a mesh of the service.
#[derive(Default)]
pub struct Form {
    /// The part `mesh`.
    pub file: Option<MeshFile>,
    /// The part `request`, a JSON document.
    pub request: Option<Value>,
    /// All other parts, as text.
    pub fields: Vec<(String, String)>,
    /// For a form with much text; to be kept while that is worked on.
    pub permit: Option<LargeBodyPermit>,
}

/// An uploaded mesh file.
pub struct MeshFile {
    /// Its bytes.
    pub upload: Upload,
    /// The name that the sender gave: to be shown, never used as a path.
    pub name: Option<String>,
    /// The format that the sender named; without one it is recognised by the bytes.
    pub format: Option<MeshFormat>,
}

/// Reads a multipart form whose parts may come in any order. The file goes straight to disk; all other
/// parts together may have `text_limit` bytes.
pub async fn read(app: &App, request: Request, text_limit: usize) -> Result<Form, Error> {
    let limit = app.max_upload_bytes + FORM_OVERHEAD_BYTES + text_limit as u64;
    let (parts, body) = body::check_declared(request, limit)?.into_parts();
    let budget = ByteBudget::default();
    let body = Body::from_stream(body::limited(body, limit, budget.clone()));
    let mut multipart = Multipart::from_request(Request::from_parts(parts, body), &())
        .await
        .map_err(|_| Error::bad_request("the Content-Type of a form must name its boundary"))?;

    let refuse = |fault: MultipartError| refusal(&fault, limit);
    let mut form = Form::default();
    let mut text_bytes = 0;
    for count in 0.. {
        budget.start(MAX_HELD_BYTES);
        let Some(mut part) = multipart.next_field().await.map_err(refuse)? else {
            break;
        };
        budget.lift();
        check_head(&part, count)?;
        let name = part.name().unwrap_or_default().to_owned();
        if name == "request" {
            check_json(&part)?;
        }
        if name == "mesh" {
            if form.file.is_some() {
                return Err(Error::bad_request("the form has two mesh files; send one"));
            }
            form.file = Some(receive(app, part, limit).await?);
            continue;
        }
        let mut bytes = Vec::new();
        while let Some(piece) = part.chunk().await.map_err(refuse)? {
            text_bytes += piece.len();
            if text_bytes > text_limit {
                return Err(Error::too_large(format!(
                    "the parts beside the file may have at most {text_limit} bytes"
                )));
            }
            if text_bytes > LARGE_BYTES && form.permit.is_none() {
                form.permit = Some(app.large_bodies.admit()?);
            }
            bytes.extend_from_slice(&piece);
        }
        if name == "request" {
            if form.request.is_some() {
                return Err(Error::bad_request(
                    "the form has two parts named request; send one",
                ));
            }
            form.request = Some(json_body::parse(&bytes, text_limit)?);
        } else {
            let text = String::from_utf8(bytes)
                .map_err(|_| Error::bad_request("the fields of a form must be UTF-8"))?;
            form.fields.push((name, text));
        }
    }
    Ok(form)
}

impl Form {
    /// Removes `format` and `scale`, which say how the file is read, from the settings, whether these are
    /// fields or JSON, and returns them. A `format` given there takes precedence over the name and the
    /// type of the file. `units` is a setting of the job as well and stays.
    pub fn take_options(&mut self) -> Result<MeshOptions, Error> {
        let mut take = |name: &str| -> Result<Option<Value>, Error> {
            if let Some(Value::Object(request)) = &mut self.request {
                return Ok(request.remove(name));
            }
            let mut found = self.fields.iter().filter(|(field, _)| field == name);
            let setting = FILE_SETTINGS.iter().find(|setting| setting.name == name);
            let value = setting.zip(found.next());
            let value = value.map(|(setting, (_, text))| setting.value_of_text(text));
            if found.next().is_some() {
                return Err(Error::invalid_field(
                    &text::pointer(name),
                    "given more than once; give it once",
                ));
            }
            self.fields.retain(|(field, _)| field != name);
            Ok(value)
        };
        let (format, scale) = (take("format")?, take("scale")?);
        let format = match format
            .as_ref()
            .map(|value| value.as_str().and_then(MeshFormat::from_name))
        {
            None => self.file.as_ref().and_then(|file| file.format),
            Some(Some(format)) => Some(format),
            Some(None) => {
                return Err(Error::invalid_field(
                    "/format",
                    format!("must be {}", MeshFormat::NAMES),
                ));
            }
        };
        let scale = match scale.as_ref().map(Value::as_f64) {
            None => 1.0,
            Some(Some(scale)) if MeshOptions::is_scale(scale) => scale,
            Some(_) => {
                let detail = format!("must be {}", MeshOptions::SCALES);
                return Err(Error::invalid_field("/scale", detail));
            }
        };
        Ok(MeshOptions {
            format,
            units: None,
            scale,
        })
    }
}

/// Reads a raw body as a mesh file, straight to disk.
pub async fn read_raw(
    app: &App,
    request: Request,
    format: Option<MeshFormat>,
) -> Result<MeshFile, Error> {
    let limit = app.max_upload_bytes;
    let body = body::check_declared(request, limit)?.into_body();
    let pieces = body::limited(body, limit, ByteBudget::default());
    pin_mut!(pieces);
    let mut upload = app.service.begin_upload().await?;
    while let Some(piece) = pieces.next().await {
        upload
            .write(&piece.map_err(|fault| fault.refusal(limit))?)
            .await?;
    }
    Ok(MeshFile {
        upload,
        name: None,
        format,
    })
}

async fn receive(app: &App, mut part: Field<'_>, limit: u64) -> Result<MeshFile, Error> {
    let name = part.file_name().map(shown_name).transpose()?.flatten();
    let format = name
        .as_deref()
        .and_then(|name| name.rsplit_once('.'))
        .and_then(|(_, ending)| MeshFormat::from_name(ending))
        .or_else(|| part.content_type().and_then(MeshFormat::from_media_type));
    let mut upload = app.service.begin_upload().await?;
    let mut bytes = 0;
    while let Some(piece) = part.chunk().await.map_err(|fault| refusal(&fault, limit))? {
        bytes += piece.len() as u64;
        if bytes > app.max_upload_bytes {
            return Err(BodyFault::TooLarge.refusal(app.max_upload_bytes));
        }
        upload.write(&piece).await?;
    }
    Ok(MeshFile {
        upload,
        name,
        format,
    })
}

/// Returns what may be shown of the file name that a sender gave: its last segment.
fn shown_name(name: &str) -> Result<Option<String>, Error> {
    if name.len() > MAX_NAME_BYTES || name.chars().any(text::is_unsafe) {
        return Err(Error::invalid_field(
            "/mesh",
            "a file name may have at most 255 bytes and no control characters or marks that \
             change the direction of writing",
        ));
    }
    let last = name.rsplit(['/', '\\']).next();
    Ok(last.filter(|last| !last.is_empty()).map(str::to_owned))
}

/// Refuses a part `request` whose type is something other than JSON. Few clients name the type: many
/// send the part as text, or as bytes when it comes from a file.
fn check_json(part: &Field<'_>) -> Result<(), Error> {
    match media_type::of_body(part.headers())?.as_deref() {
        None | Some("application/json" | "text/plain" | "application/octet-stream") => Ok(()),
        Some(_) => Err(Error::unsupported("the part request is read as JSON only")),
    }
}

fn check_head(part: &Field<'_>, parts_before: usize) -> Result<(), Error> {
    if parts_before >= MAX_PARTS {
        return Err(Error::too_large(format!(
            "a form may have at most {MAX_PARTS} parts; all settings can go as JSON into one part \
             named request"
        )));
    }
    let bytes: usize = part
        .headers()
        .iter()
        .map(|(name, value)| name.as_str().len() + value.len())
        .sum();
    if bytes > MAX_PART_HEADER_BYTES {
        return Err(BodyFault::PartHeaders.refusal(0));
    }
    Ok(())
}

fn refusal(fault: &MultipartError, limit: u64) -> Error {
    BodyFault::source_of(fault).map_or_else(
        || {
            Error::bad_request(
                "the form is badly framed, ends early, or has a control character in a name",
            )
        },
        |fault| fault.refusal(limit),
    )
}
