//! Grasps as files of other formats.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;

use super::access::Caller;
use super::error::Error;
use super::openapi::Binary;
use super::outcome::{GraspParameter, Outcome, chosen};
use super::query::{Name, Parameters};
use super::{App, reply};
use crate::export::{self, Gripper};
use crate::wire::{Chosen, Units};

const GLB: &str = "model/gltf-binary";
const CSV: &str = "text/csv; charset=utf-8; header=present";
const YAML: &str = "application/yaml";
const JSON: &str = "application/json";

/// Read a grasp as GLB
///
/// The mesh and, as named nodes, for each contact an arrow that ends in it along the inward normal and its friction
/// cone, mirrored to the outside; the centre of mass and the weakest wrench. Numbers are in the `extras` of the nodes.
/// Coordinates are those of the mesh's frame and unit; the root node scales them to metres where the unit is known.
#[utoipa::path(
    get, path = "/jobs/{id}/grasp.glb",
    operation_id = "export_grasp", tag = "pictures and exports",
    params(("id" = String, Path, description = "Id of the job"), GraspParameter),
    responses(
        (status = 200, description = "The file", content((Binary = "model/gltf-binary")), headers(
            ("ETag" = String, description = "Names these bytes"),
            ("Content-Disposition" = String, description = "A name to keep it under"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 406, description = "GLB is not accepted"),
        (status = 409, description = "The job has no such grasp, or none yet"),
        (status = 410, description = "The job has expired, or its mesh has been deleted"),
    ),
)]
pub async fn glb(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let chosen = chosen(&query.only(&["grasp"])?)?;
    reply::accepted(&headers, GLB)?;
    let outcome = Outcome::of(&app, &owner, &id).await?;
    outcome.grasp(chosen)?;
    let tag = outcome.tag(&format!("glb-{}", chosen.name()));
    if let Some(unchanged) = reply::not_modified(&headers, &tag) {
        return Ok(unchanged);
    }
    let name = format!("grasp-{}.glb", outcome.job.id);
    let make = outcome.with_mesh(&app, &owner, 0, move |mesh, outcome| {
        let grasp = outcome.grasp(chosen)?;
        export::grasp_glb(mesh, &outcome.result, &grasp).map_err(Error::internal)
    });
    reply::file(&tag, GLB, Some(&name), make.await??)
}

/// Read a grasp as a table
///
/// A line for each contact: number, position, inward normal, triangle and barycentric coordinates, the force that
/// answers the weakest wrench, torsion, and whether it was fixed. In the mesh's frame and unit; RFC 4180, with a header.
#[utoipa::path(
    get, path = "/jobs/{id}/grasp.csv",
    operation_id = "export_contacts", tag = "pictures and exports",
    params(("id" = String, Path, description = "Id of the job"), GraspParameter),
    responses(
        (status = 200, description = "The table", content((String = "text/csv")), headers(("ETag" = String, description = "Names these bytes"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 406, description = "CSV is not accepted"),
        (status = 409, description = "The job has no such grasp, or none yet"),
        (status = 410, description = "The job has expired"),
    ),
)]
pub async fn csv(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let chosen = chosen(&query.only(&["grasp"])?)?;
    reply::accepted(&headers, "text/csv")?;
    let outcome = Outcome::of(&app, &owner, &id).await?;
    let grasp = outcome.grasp(chosen)?;
    let tag = outcome.tag(&format!("csv-{}", chosen.name()));
    if let Some(unchanged) = reply::not_modified(&headers, &tag) {
        return Ok(unchanged);
    }
    let name = format!("grasp-{}.csv", outcome.job.id);
    reply::file(&tag, CSV, Some(&name), export::contacts_csv(&grasp))
}

/// Read how a search came along, as a table
///
/// A line for each generation, evenly chosen ones of more than 1,000: best and mean quality ε, how many of the
/// population are force closure, evaluations and seconds so far. RFC 4180, with a header.
#[utoipa::path(
    get, path = "/jobs/{id}/convergence.csv",
    operation_id = "export_history", tag = "pictures and exports",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The table", content((String = "text/csv")), headers(("ETag" = String, description = "Names these bytes"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "No query parameter is taken"),
        (status = 404, description = "No such job"),
        (status = 406, description = "CSV is not accepted"),
        (status = 409, description = "The job has no result, or none yet"),
        (status = 410, description = "The job has expired"),
    ),
)]
pub async fn history(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    query.only(&[])?;
    reply::accepted(&headers, "text/csv")?;
    let outcome = Outcome::of(&app, &owner, &id).await?;
    let tag = outcome.tag("history-csv");
    if let Some(unchanged) = reply::not_modified(&headers, &tag) {
        return Ok(unchanged);
    }
    let name = format!("convergence-{}.csv", outcome.job.id);
    reply::file(&tag, CSV, Some(&name), export::history_csv(&outcome.result))
}

/// Read a grasp of two contacts for Isaac Sim
///
/// `isaac_grasp` 1.0: the pose of a gripper with two parallel jaws in the frame of the mesh, in metres. What is assumed
/// stands in the file.
#[utoipa::path(
    get, path = "/jobs/{id}/grasp.isaac.yaml",
    operation_id = "export_isaac_grasp", tag = "pictures and exports",
    params(
        ("id" = String, Path, description = "Id of the job"),
        GraspParameter,
        ("units" = Option<Units>, Query, description = "Unit of the mesh, where the job does not say"),
    ),
    responses(
        (status = 200, description = "The pose", content((String = "application/yaml")), headers(("ETag" = String, description = "Names these bytes"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 406, description = "YAML is not accepted"),
        (status = 409, description = "The job has no such grasp, or none yet, or it cannot be said in this format: it has not two contacts, these are not opposed, or the unit is not known"),
        (status = 410, description = "The job has expired"),
    ),
)]
pub async fn isaac(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let query = query.only(&["grasp", "units"])?;
    reply::accepted(&headers, YAML)?;
    let (tag, gripper) = gripper(&app, &owner, &id, &query, "isaac").await?;
    match reply::not_modified(&headers, &tag) {
        Some(unchanged) => Ok(unchanged),
        None => reply::file(&tag, YAML, Some("grasp.isaac.yaml"), gripper.isaac()),
    }
}

/// Read a grasp of two contacts for MoveIt
///
/// The message `moveit_msgs/Grasp` as JSON: the pose of a gripper with two parallel jaws in the frame of the mesh, in
/// metres. What is assumed stands in its `_comment`.
#[utoipa::path(
    get, path = "/jobs/{id}/grasp.moveit.json",
    operation_id = "export_moveit_grasp", tag = "pictures and exports",
    params(
        ("id" = String, Path, description = "Id of the job"),
        GraspParameter,
        ("units" = Option<Units>, Query, description = "Unit of the mesh, where the job does not say"),
    ),
    responses(
        (status = 200, description = "The message", content((serde_json::Value = "application/json")), headers(("ETag" = String, description = "Names these bytes"))),
        (status = 304, description = "As the client has it"),
        (status = 400, description = "A query parameter cannot be used"),
        (status = 404, description = "No such job"),
        (status = 406, description = "JSON is not accepted"),
        (status = 409, description = "The job has no such grasp, or none yet, or it cannot be said in this format: it has not two contacts, these are not opposed, or the unit is not known"),
        (status = 410, description = "The job has expired"),
    ),
)]
pub async fn moveit(
    State(app): State<App>,
    Caller(owner): Caller,
    Name(id): Name,
    query: Parameters,
    headers: HeaderMap,
) -> Result<Response, Error> {
    let query = query.only(&["grasp", "units"])?;
    reply::accepted(&headers, JSON)?;
    let (tag, gripper) = gripper(&app, &owner, &id, &query, "moveit").await?;
    match reply::not_modified(&headers, &tag) {
        Some(unchanged) => Ok(unchanged),
        None => {
            let message = serde_json::to_vec_pretty(&gripper.moveit()).map_err(Error::internal)?;
            reply::file(&tag, JSON, Some("grasp.moveit.json"), message)
        }
    }
}

async fn gripper(
    app: &App,
    owner: &crate::jobs::Owner,
    id: &str,
    query: &Parameters,
    kind: &str,
) -> Result<(String, Gripper), Error> {
    let chosen: Chosen = chosen(query)?;
    let units = query.parse("units", Units::NAMES, Units::named)?;
    let outcome = Outcome::of(app, owner, id).await?;
    if let (Some(known), Some(given)) = (outcome.result.units, units)
        && known != given
    {
        let detail = format!(
            "the job says that its mesh is in {}; leave it out",
            known.name()
        );
        return Err(Error::query("units", detail));
    }
    let grasp = outcome.grasp(chosen)?;
    let gripper = Gripper::of(&outcome.result, &grasp, units);
    let gripper = gripper.map_err(|why| Error::conflict(why.to_string()))?;
    let unit = units.map_or("", Units::name);
    Ok((
        outcome.tag(&format!("{kind}-{}-{unit}", chosen.name())),
        gripper,
    ))
}
