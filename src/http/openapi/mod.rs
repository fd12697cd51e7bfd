//! The description of the service for programs.

mod bodies;
mod errors;
mod examples;

use utoipa::Modify;
use utoipa::openapi::path::Operation;
use utoipa::openapi::schema::{SchemaType, Type};
use utoipa::openapi::security::{Http, HttpAuthScheme, SecurityScheme};
use utoipa::openapi::{OpenApi, RefOr, Schema};

pub use bodies::{
    BatchBody, Binary, EvaluationForm, EvaluationJson, JobForm, JobRequest, MeshForm,
};
pub use errors::{describe_errors, describe_guard};
pub use examples::show_examples;

use crate::wire::{FieldError, JobProgress, Problem, WebhookEvent};

#[derive(utoipa::OpenApi)]
#[openapi(
    info(
        title = "graspd",
        description = "Plans force-closure grasps on triangle meshes.\n\n\
            Every error is `application/problem+json` (RFC 9457). Lengths are in the mesh's own \
            unit, normals point into the body, torques are about the centre of mass.\n\n\
            The examples are of the chess knight, `examples/meshes/knight.stl` of the repository: send it to \
            `POST /meshes` once, here or with `curl -F mesh=@knight.stl localhost:8080/meshes`, and every \
            example runs as it stands. What a run looks like is on [the page](/).",
    ),
    tags(
        (name = "jobs", description = "Planning runs"),
        (name = "batches", description = "Many planning runs as one"),
        (name = "evaluations", description = "Quality of given grasps"),
        (name = "meshes", description = "Bodies to grasp"),
        (name = "pictures and exports", description = "Grasps to look at, and for other programs"),
        (name = "service", description = "The service itself"),
    ),
    components(schemas(Problem, FieldError, JobProgress, WebhookEvent)),
    modifiers(&Keys),
)]
struct Description;

/// Adds how an API key is sent.
struct Keys;

impl Modify for Keys {
    fn modify(&self, api: &mut OpenApi) {
        let components = api.components.get_or_insert_default();
        let scheme = SecurityScheme::Http(Http::new(HttpAuthScheme::Bearer));
        components.add_security_scheme("api_key", scheme);
    }
}

/// The description without its routes.
pub fn description() -> OpenApi {
    <Description as utoipa::OpenApi>::openapi()
}

fn operations(api: &mut OpenApi) -> impl Iterator<Item = &mut Operation> {
    api.paths.paths.values_mut().flat_map(|path| {
        [&mut path.get, &mut path.post, &mut path.delete]
            .into_iter()
            .flatten()
    })
}

/// Parameters may be left out, but never say `null`, as optional ones are described at first.
pub fn forbid_null_parameters(api: &mut OpenApi) {
    let parameters =
        operations(api).flat_map(|operation| operation.parameters.iter_mut().flatten());
    for parameter in parameters {
        if let RefOr::T(parameter) = parameter
            && let Some(RefOr::T(Schema::Object(object))) = &mut parameter.schema
            && let SchemaType::Array(kinds) = &mut object.schema_type
        {
            kinds.retain(|kind| *kind != Type::Null);
            if let [kind] = &kinds[..] {
                object.schema_type = SchemaType::Type(kind.clone());
            }
        }
    }
}
