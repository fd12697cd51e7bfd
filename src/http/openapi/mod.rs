//! The OpenAPI document. utoipa describes what a handler says of itself; `rules` adds what operations
//! have in common, `errors` the bodies of refusals, `examples` the examples.

pub mod bodies;
mod errors;
mod examples;
pub mod headers;
mod operations;
pub mod rules;

use utoipa::Modify;
use utoipa::openapi::schema::{SchemaType, Type};
use utoipa::openapi::security::{Http, HttpAuthScheme, SecurityScheme};
use utoipa::openapi::{OpenApi, RefOr, Schema};

use self::operations::operations;
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

/// Describes how an API key is sent.
struct Keys;

impl Modify for Keys {
    fn modify(&self, api: &mut OpenApi) {
        let components = api.components.get_or_insert_default();
        let scheme = SecurityScheme::Http(Http::new(HttpAuthScheme::Bearer));
        components.add_security_scheme("api_key", scheme);
    }
}

/// Returns the document without any operation.
pub fn document() -> OpenApi {
    <Description as utoipa::OpenApi>::openapi()
}

/// Removes `null` from the types of parameters: one that is optional may be left out, but is never null.
fn forbid_null_parameters(api: &mut OpenApi) {
    let parameters =
        operations(api).flat_map(|(_, operation)| operation.parameters.iter_mut().flatten());
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

/// Completes the document once all operations are in it.
pub fn finish(api: &mut OpenApi) {
    errors::describe_problems(api);
    forbid_null_parameters(api);
    examples::show_examples(api);
}
