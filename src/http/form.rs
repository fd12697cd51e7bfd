//! Uploads: a mesh as a raw body, or as one part of a form beside the settings.

use axum::body::Body;
use axum::extract::multipart::{Field, MultipartError};
use axum::extract::{FromRequest, Multipart, Request};
use futures_util::{StreamExt, pin_mut};
use serde_json::Value;

use super::App;
use super::body::{self, Fault, Meter, Place};
use super::error::Error;
use crate::jobs::Upload;
use crate::wire::{MeshOptions, form_value, text};
use graspd_mesh_io::MeshFormat;

const MAX_PARTS: usize = 16;
const MAX_PART_HEADER_BYTES: usize = 8 * 1024;
/// Most of a body that is held while the headers of a part are looked for. The reader is handed
/// pieces of up to 400 KiB, which may hold much more than those headers.
const MAX_HELD_BYTES: u64 = 1 << 20;
const MAX_NAME_BYTES: usize = 255;
/// Room for the parts beside the file, their headers and the boundaries.
const FORM_OVERHEAD_BYTES: u64 = 256 * 1024;

/// A form with everything in it read; the file is on disk, not yet kept.
#[derive(Default)]
pub struct Form {
    /// Part `mesh`.
    pub file: Option<MeshFile>,
    /// Part `request`, a JSON document.
    pub request: Option<Value>,
    /// All other parts, as text.
    pub fields: Vec<(String, String)>,
    /// Among those who may hold much text; to be kept while it is worked on.
    pub place: Option<Place>,
}

/// An uploaded mesh file.
pub struct MeshFile {
    /// Its bytes.
    pub upload: Upload,
    /// The name its sender gave it: to be shown, never a path.
    pub name: Option<String>,
    /// Its format, if its sender said so; else its bytes must tell.
    pub format: Option<MeshFormat>,
}

/// Reads a multipart form, parts in any order, the file straight to disk; all other parts together may
/// have `text_limit` bytes.
pub async fn read(app: &App, request: Request, text_limit: usize) -> Result<Form, Error> {
    let limit = app.max_upload_bytes + FORM_OVERHEAD_BYTES + text_limit as u64;
    let (parts, body) = body::check_declared(request, limit)?.into_parts();
    let meter = Meter::default();
    let body = Body::from_stream(body::metered(body, limit, meter.clone()));
    let mut multipart = Multipart::from_request(Request::from_parts(parts, body), &())
        .await
        .map_err(|_| Error::bad_request("the Content-Type of a form must name its boundary"))?;

    let refuse = |fault: MultipartError| broken(&fault, limit);
    let mut form = Form::default();
    let mut text_bytes = 0;
    for count in 0.. {
        meter.expect_within(MAX_HELD_BYTES);
        let Some(mut part) = multipart.next_field().await.map_err(refuse)? else {
            break;
        };
        meter.relax();
        check_head(&part, count)?;
        let name = part.name().unwrap_or_default().to_owned();
        if name == "request" {
            check_json(&part)?;
        }
        if name == "mesh" {
            if form.file.is_some() {
                return Err(Error::bad_request(
                    "one mesh file is wanted, this form has two",
                ));
            }
            form.file = Some(store(app, part, limit).await?);
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
            if text_bytes > body::LARGE_BYTES && form.place.is_none() {
                form.place = Some(body::place(&app.large_bodies)?);
            }
            bytes.extend_from_slice(&piece);
        }
        if name == "request" {
            if form.request.is_some() {
                return Err(Error::bad_request(
                    "one part named request is wanted, not two",
                ));
            }
            form.request = Some(body::parse_json(&bytes, text_limit)?);
        } else {
            let text = String::from_utf8(bytes)
                .map_err(|_| Error::bad_request("the fields of a form must be UTF-8"))?;
            form.fields.push((name, text));
        }
    }
    Ok(form)
}

impl Form {
    /// Takes out what says how the file is to be read and nothing else does: `format`, where name and type of
    /// the file count less, and `scale`, wherever the settings are. The unit is a setting of the job too and
    /// stays.
    pub fn take_options(&mut self) -> Result<MeshOptions, Error> {
        let mut take = |name: &str| -> Result<Option<Value>, Error> {
            if let Some(Value::Object(request)) = &mut self.request {
                return Ok(request.remove(name));
            }
            let mut found = self.fields.iter().filter(|(field, _)| field == name);
            let value = found.next().map(|(_, text)| form_value(name, text));
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
                    format!("{} is wanted", MeshFormat::NAMES),
                ));
            }
        };
        let scale = match scale.as_ref().map(Value::as_f64) {
            None => 1.0,
            Some(Some(scale)) if MeshOptions::is_scale(scale) => scale,
            Some(_) => {
                let wanted = format!("{} is wanted", MeshOptions::SCALES);
                return Err(Error::invalid_field("/scale", wanted));
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
    let pieces = body::metered(body, limit, Meter::default());
    pin_mut!(pieces);
    let mut upload = app.service.begin_upload().await?;
    while let Some(piece) = pieces.next().await {
        upload
            .write(&piece.map_err(|fault| fault.refuse(limit))?)
            .await?;
    }
    Ok(MeshFile {
        upload,
        name: None,
        format,
    })
}

async fn store(app: &App, mut part: Field<'_>, limit: u64) -> Result<MeshFile, Error> {
    let name = part.file_name().map(shown_name).transpose()?.flatten();
    let format = name
        .as_deref()
        .and_then(|name| name.rsplit_once('.'))
        .and_then(|(_, ending)| MeshFormat::from_name(ending))
        .or_else(|| part.content_type().and_then(MeshFormat::from_media_type));
    let mut upload = app.service.begin_upload().await?;
    let mut bytes = 0;
    while let Some(piece) = part.chunk().await.map_err(|fault| broken(&fault, limit))? {
        bytes += piece.len() as u64;
        if bytes > app.max_upload_bytes {
            return Err(Fault::TooLarge.refuse(app.max_upload_bytes));
        }
        upload.write(&piece).await?;
    }
    Ok(MeshFile {
        upload,
        name,
        format,
    })
}

/// What of a sender's file name may be shown: its last segment, if it is fit for that.
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

/// Refuses a part that says it is something else than JSON. Few clients say that it is: many
/// send it as text, or as bytes when it comes from a file.
fn check_json(part: &Field<'_>) -> Result<(), Error> {
    match body::media_type(part.headers())?.as_deref() {
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
        return Err(Fault::PartHeaders.refuse(0));
    }
    Ok(())
}

fn broken(fault: &MultipartError, limit: u64) -> Error {
    Fault::beneath(fault).map_or_else(
        || {
            Error::bad_request(
                "the form is badly framed, ends early, or has a control character in a name",
            )
        },
        |fault| fault.refuse(limit),
    )
}
