//! The entry of an export in the OpenAPI document.

use utoipa::openapi;
use utoipa::openapi::path::{OperationBuilder, Paths, PathsBuilder};
use utoipa::openapi::schema::{ObjectBuilder, Schema};
use utoipa::openapi::{ContentBuilder, Header, HttpMethod, PathItem, RefOr, ResponseBuilder};

use super::parameters;
use crate::export::{Export, Writer};
use crate::http::request::query::{component, text};

/// Returns the path of an export with its operation. What all operations have in common is added to
/// the whole document later.
pub fn paths(export: &Export) -> Paths {
    let header = |description: &str| {
        let mut header = Header::new(text());
        header.description = Some(description.to_owned());
        header
    };
    let content = ContentBuilder::new().schema(Some(schema(export.essence())));
    let mut file = ResponseBuilder::new()
        .description("The file")
        .content(export.essence(), content.build())
        .header("ETag", header("Names these bytes"));
    if export.file_name.is_some() {
        file = file.header("Content-Disposition", header("A name to save it under"));
    }
    let (tag, refusals): (&str, &[(&str, &str)]) = match export.writer {
        Writer::Mesh { .. } => ("meshes", &[]),
        Writer::Result(_) | Writer::Chart { .. } => (
            "pictures and exports",
            &[("409", "The job has no result, or none yet")],
        ),
        Writer::Grasp(_) => (
            "pictures and exports",
            &[("409", "The job has no such grasp, or none yet")],
        ),
        Writer::Scene { .. } => (
            "pictures and exports",
            &[
                ("409", "The job has no such grasp, or none yet"),
                ("410", "The job has expired, or its mesh has been deleted"),
            ],
        ),
    };
    let mut operation = OperationBuilder::new()
        .operation_id(Some(export.operation))
        .tag(tag)
        .summary(Some(export.summary))
        .description(Some(export.description))
        .response("200", file.build());
    for (status, description) in refusals {
        let refusal = ResponseBuilder::new().description(*description);
        operation = operation.response(*status, refusal.build());
    }
    for &parameter in export.parameters {
        operation = operation.parameter(parameters::describe(parameter));
    }
    PathsBuilder::new()
        .path(
            export.path(),
            PathItem::new(HttpMethod::Get, operation.build()),
        )
        .build()
}

fn schema(media_type: &str) -> RefOr<Schema> {
    match media_type {
        "application/json" => ObjectBuilder::new()
            .schema_type(openapi::schema::SchemaType::AnyValue)
            .into(),
        "image/png" | "model/gltf-binary" => component("Binary"),
        _ => text(),
    }
}
