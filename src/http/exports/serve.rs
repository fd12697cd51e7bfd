//! Serves an export: reads the choices, finds the source, and writes the file for a client that does
//! not have it.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use axum::routing::get;
use utoipa_axum::router::UtoipaMethodRouter;

use super::{describe, parameters};
use crate::export::{EXPORTS, Export, ExportError, JobSource, MeshSource, Options, Writer};
use crate::http::app::App;
use crate::http::jobs::job_result::JobResult;
use crate::http::layers::auth::Caller;
use crate::http::request::accept;
use crate::http::request::query::{Name, Pairs};
use crate::http::response::conditional::{self, FileHead};
use crate::http::response::error::Error;
use crate::jobs::Owner;

/// Returns a route for each row of the table, with its description.
pub fn routes() -> impl Iterator<Item = UtoipaMethodRouter<App>> {
    EXPORTS.iter().map(|export| {
        let serve = get(
            async move |State(app): State<App>,
                        Caller(owner): Caller,
                        Name(id): Name,
                        given: Pairs,
                        headers: HeaderMap| {
                let options = parameters::read(export, &given)?;
                accept::require(&headers, export.essence())?;
                match export.writer {
                    Writer::Mesh { .. } => {
                        of_mesh(export, &app, &owner, &id, options, &headers).await
                    }
                    _ => of_job(export, &app, &owner, &id, options, &headers).await,
                }
            },
        );
        (Vec::new(), describe::paths(export), serve)
    })
}

async fn of_job(
    export: &'static Export,
    app: &App,
    owner: &Owner,
    id: &str,
    options: Options,
    headers: &HeaderMap,
) -> Result<Response, Error> {
    let job = JobResult::of(app, owner, id).await?;
    check_units(&job, &options)?;
    let head = FileHead {
        tag: entity_tag(job.record.id, &export.variant(&options)),
        media_type: export.media_type,
        name: export
            .file_name
            .map(|name| name.replace("{id}", &job.record.id.to_string())),
    };
    let title = job.title();
    let source = JobSource {
        result: &job.result,
        title: &title,
        options: &options,
    };
    match export.writer {
        // Writing these is as cheap as knowing that the client has them, and says what is wrong with a
        // grasp to everyone.
        Writer::Result(write) => {
            let bytes = write(&source)?;
            conditional::file(headers, head, async { Ok(bytes) }).await
        }
        Writer::Grasp(write) => {
            let bytes = write(&source, &job.grasp(options.grasp)?)?;
            conditional::file(headers, head, async { Ok(bytes) }).await
        }
        Writer::Chart { pixels, write } => {
            let pixels = pixels(&options);
            let draw = move || {
                write(&JobSource {
                    result: &job.result,
                    title: &title,
                    options: &options,
                })
            };
            let drawn = async { Ok(app.service.draw_without_mesh(pixels, draw).await??) };
            conditional::file(headers, head, drawn).await
        }
        Writer::Scene { pixels, write } => {
            job.grasp(options.grasp)?;
            let pixels = pixels(&options);
            let draw = job.with_mesh(app, owner, pixels, move |mesh, job| {
                let source = JobSource {
                    result: &job.result,
                    title: &title,
                    options: &options,
                };
                Ok(write(&source, &job.grasp(options.grasp)?, mesh)?)
            });
            conditional::file(headers, head, async { draw.await? }).await
        }
        Writer::Mesh { .. } => Err(Error::internal("an export of a mesh was asked of a job")),
    }
}

async fn of_mesh(
    export: &'static Export,
    app: &App,
    owner: &Owner,
    id: &str,
    options: Options,
    headers: &HeaderMap,
) -> Result<Response, Error> {
    let Writer::Mesh { pixels, write } = export.writer else {
        return Err(Error::internal("an export of a job was asked of a mesh"));
    };
    let mesh = app.service.mesh(owner, id).await?;
    let (format, units) = (mesh.format, mesh.units);
    let title = mesh.file_name.unwrap_or_else(|| mesh.id.to_string());
    // Name and unit of a mesh can change while its id stays.
    let record = conditional::hash(format!("{title}\n{units:?}"));
    let variant = format!("{record}-{}", export.variant(&options));
    let head = FileHead {
        tag: entity_tag(&mesh.id.as_str()[..32], &variant),
        media_type: export.media_type,
        name: export.file_name.map(str::to_owned),
    };
    let draw = app.service.draw(owner, id, pixels(&options), move |mesh| {
        write(&MeshSource {
            mesh,
            format,
            units,
            title: &title,
            options: &options,
        })
    });
    conditional::file(headers, head, async { Ok(draw.await??) }).await
}

/// Returns the entity tag of something made of a result or a mesh. Neither changes any more, so the
/// bytes depend on the choices and on this version of the program alone.
pub fn entity_tag(id: impl std::fmt::Display, variant: &str) -> String {
    format!("\"{id}-{variant}-{}\"", env!("CARGO_PKG_VERSION"))
}

/// Refuses a unit that contradicts the job.
fn check_units(job: &JobResult, options: &Options) -> Result<(), Error> {
    match (job.result.units, options.units) {
        (Some(known), Some(given)) if known != given => {
            let detail = format!(
                "the job says that its mesh is in {}; leave it out",
                known.name()
            );
            Err(Error::query("units", detail))
        }
        _ => Ok(()),
    }
}

impl From<ExportError> for Error {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Pose(why) => Self::conflict(why.to_string()),
            ExportError::Picture(fault) => Self::internal(fault),
            ExportError::Json(fault) => Self::internal(fault),
        }
    }
}
