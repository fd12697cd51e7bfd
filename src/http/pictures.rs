//! Pictures of grasps and of searches.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use utoipa::IntoParams;

use super::access::Caller;
use super::error::Error;
use super::openapi::Binary;
use super::outcome::{GraspParameter, Outcome, chosen};
use super::picture_query::{self, Format, PictureParameters, Theme};
use super::query::{Name, Parameters};
use super::{App, reply};
use crate::picture::{self, GraspOptions, Viewpoint};

/// Draw a grasp
///
/// The shaded body; each finger as an arrow that comes from outside along the inward normal and ends in its contact, its
/// friction cone mirrored to the outside; the centre of mass and the weakest wrench; below, the numbers and what the
/// marks mean. What the body hides is faint.
#[utoipa::path(
    get, path = "/jobs/{id}/grasp.png",
    operation_id = "draw_grasp", tag = "pictures and exports",
    params(("id" = String, Path, description = "Id of the job"), GraspParameter, DrawingParameters, PictureParameters),
    responses(
        (status = 200, description = "The picture", content((Binary = "image/png")), headers(("ETag" = String, description = "Names these bytes"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 406, description = "PNG is not accepted"),
        (status = 409, description = "The job has no such grasp, or none yet"),
        (status = 410, description = "The job has expired, or its mesh has been deleted"),
    ),
)]
pub async fn grasp_png(
    State(app): State<App>,
    caller: Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    grasp(&app, caller, &id, query, &headers, Format::Png).await
}

/// Draw a grasp as SVG
///
/// As `grasp.png`; marks and text are lines and letters, the shaded body is made of pixels. Without a theme it is light
/// or dark as the reader prefers.
#[utoipa::path(
    get, path = "/jobs/{id}/grasp.svg",
    operation_id = "draw_grasp_svg", tag = "pictures and exports",
    params(("id" = String, Path, description = "Id of the job"), GraspParameter, DrawingParameters, PictureParameters),
    responses(
        (status = 200, description = "The picture", content((String = "image/svg+xml")), headers(("ETag" = String, description = "Names these bytes"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 406, description = "SVG is not accepted"),
        (status = 409, description = "The job has no such grasp, or none yet"),
        (status = 410, description = "The job has expired, or its mesh has been deleted"),
    ),
)]
pub async fn grasp_svg(
    State(app): State<App>,
    caller: Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    grasp(&app, caller, &id, query, &headers, Format::Svg).await
}

/// Draw how a search came along
///
/// Best and mean quality ε over the generations, with the first grasp and what sliding the contacts brought.
#[utoipa::path(
    get, path = "/jobs/{id}/convergence.png",
    operation_id = "draw_convergence", tag = "pictures and exports",
    params(("id" = String, Path, description = "Id of the job"), PictureParameters),
    responses(
        (status = 200, description = "The picture", content((Binary = "image/png")), headers(("ETag" = String, description = "Names these bytes"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 406, description = "PNG is not accepted"),
        (status = 409, description = "The job has no result, or none yet"),
        (status = 410, description = "The job has expired"),
    ),
)]
pub async fn convergence_png(
    State(app): State<App>,
    caller: Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    convergence(&app, caller, &id, query, &headers, Format::Png).await
}

/// Draw how a search came along, as SVG
///
/// Without a theme it is light or dark as the reader prefers.
#[utoipa::path(
    get, path = "/jobs/{id}/convergence.svg",
    operation_id = "draw_convergence_svg", tag = "pictures and exports",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("theme" = inline(Option<Theme>), Query, description = "Colours; default is what the reader prefers"),
    ),
    responses(
        (status = 200, description = "The picture", content((String = "image/svg+xml")), headers(("ETag" = String, description = "Names these bytes"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 406, description = "SVG is not accepted"),
        (status = 409, description = "The job has no result, or none yet"),
        (status = 410, description = "The job has expired"),
    ),
)]
pub async fn convergence_svg(
    State(app): State<App>,
    caller: Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let query = query.only(&["theme"])?;
    convergence(&app, caller, &id, query, &headers, Format::Svg).await
}

/// How a query has a grasp drawn.
#[derive(IntoParams)]
#[into_params(parameter_in = Query)]
#[allow(
    dead_code,
    reason = "only described; the query is read as GraspOptions"
)]
struct DrawingParameters {
    /// `both` (default): from the front, right and above, and from the opposite side; `iso`: the first of these;
    /// `front`, `back`, `left`, `right`, `top`, `bottom`; or azimuth and elevation in degrees, such as `30,20`
    view: Option<String>,
    /// Whether numbers and meanings stand below; default true. Without, marks are larger
    legend: Option<bool>,
}

fn grasp_options(query: &Parameters, format: Format) -> Result<GraspOptions, Error> {
    let view = query.parse("view", Viewpoint::NAMES, Viewpoint::named)?;
    let legend = query.parse("legend", "true or false", |text| text.parse().ok())?;
    let picture::Options { width, background } = picture_query::of_query(query, format)?;
    Ok(GraspOptions {
        width,
        background,
        view: view.unwrap_or_default(),
        legend: legend.unwrap_or(true),
    })
}

async fn grasp(
    app: &App,
    Caller(owner): Caller,
    id: &str,
    query: Parameters,
    headers: &HeaderMap,
    format: Format,
) -> Result<Response, Error> {
    let query = query.only(&["grasp", "view", "width", "theme", "legend"])?;
    let (chosen, options) = (chosen(&query)?, grasp_options(&query, format)?);
    let kind = format.media_type();
    reply::accepted(headers, kind)?;
    let outcome = Outcome::of(app, &owner, id).await?;
    outcome.grasp(chosen)?;
    let tag = format!("{kind}-{}-{options:?}", chosen.name());
    // A list of tags is separated by commas.
    let tag = outcome.tag(&tag.replace(' ', "").replace(',', ";"));
    if let Some(unchanged) = reply::not_modified(headers, &tag) {
        return Ok(unchanged);
    }
    let make = outcome.with_mesh(
        app,
        &owner,
        options.pixels(),
        move |mesh, outcome| -> Result<Vec<u8>, Error> {
            let (grasp, result, title) = (outcome.grasp(chosen)?, &outcome.result, outcome.title());
            match format {
                Format::Svg => picture::grasp_svg(mesh, result, &grasp, &title, &options)
                    .map(String::into_bytes),
                Format::Png => picture::grasp_png(mesh, result, &grasp, &title, &options),
            }
            .map_err(Error::internal)
        },
    );
    reply::file(&tag, kind, None, make.await??)
}

async fn convergence(
    app: &App,
    Caller(owner): Caller,
    id: &str,
    query: Parameters,
    headers: &HeaderMap,
    format: Format,
) -> Result<Response, Error> {
    let picture::Options { width, background } = picture_query::options(query, format)?;
    let kind = format.media_type();
    reply::accepted(headers, kind)?;
    let outcome = Outcome::of(app, &owner, id).await?;
    let tag = outcome.tag(&format!("convergence-{kind}-{width}-{background:?}"));
    if let Some(unchanged) = reply::not_modified(headers, &tag) {
        return Ok(unchanged);
    }
    let pixels = match format {
        Format::Svg => 0,
        Format::Png => picture::convergence_pixels(width),
    };
    let make = move || -> Result<Vec<u8>, picture::PictureError> {
        let (result, title) = (&outcome.result, outcome.title());
        match format {
            Format::Svg => Ok(picture::convergence_svg(result, &title, background).into_bytes()),
            Format::Png => picture::convergence_png(result, &title, background, width),
        }
    };
    let bytes = app.service.draw_without_mesh(pixels, make).await?;
    reply::file(&tag, kind, None, bytes.map_err(Error::internal)?)
}
