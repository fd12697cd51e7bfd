//! What many operations have in common is described by rule, so that a handler describes only what
//! is its own. A rule never replaces what a handler says itself.

use utoipa::openapi::path::{Operation, ParameterBuilder, ParameterIn};
use utoipa::openapi::schema::{KnownFormat, SchemaFormat, Type};
use utoipa::openapi::security::SecurityRequirement;
use utoipa::openapi::{Header, ObjectBuilder, OpenApi, RefOr, Required, Response, ResponseBuilder};

use super::headers::IDEMPOTENCY_KEY;
use super::operations::operations;

/// The layers in front of a route.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Anyone may call it, whatever they accept.
    Public,
    /// API keys and rate limits apply, and the client has to accept what it answers.
    Guarded,
}

/// Completes the operations of routes behind the same layers.
pub fn complete(api: &mut OpenApi, access: Access) {
    for (path, operation) in operations(api) {
        describe_resource(path, operation);
        describe_query(operation);
        describe_body(operation);
        describe_success(path, operation);
        refuse(operation, "503", "The service cannot do this now");
        refuse(
            operation,
            "500",
            "A fault of the server; its log has the cause under the id in the detail",
        );
        if access == Access::Guarded {
            describe_access(operation);
        }
    }
}

/// The tag, and for a path with an id its parameter and the answers to a wrong one.
fn describe_resource(path: &str, operation: &mut Operation) {
    let tag = path.split('/').nth(1).unwrap_or_default();
    let (tag, resource) = match tag {
        "jobs" => ("jobs", "job"),
        "batches" => ("batches", "batch"),
        "meshes" => ("meshes", "mesh"),
        "evaluations" => ("evaluations", "evaluation"),
        _ => ("service", "resource"),
    };
    operation.tags.get_or_insert_with(|| vec![tag.to_owned()]);
    if !path.contains("{id}") {
        return;
    }
    let id = ParameterBuilder::new()
        .name("id")
        .parameter_in(ParameterIn::Path)
        .required(Required::True)
        .description(Some(format!("Id of the {resource}")))
        .schema(Some(ObjectBuilder::new().schema_type(Type::String)));
    operation
        .parameters
        .get_or_insert_default()
        .insert(0, id.build().into());
    refuse(operation, "404", format!("No such {resource}"));
    // Meshes expire without a trace.
    if resource != "mesh" {
        refuse(operation, "410", format!("The {resource} has expired"));
    }
}

/// Every route refuses parameters that it does not know.
fn describe_query(operation: &mut Operation) {
    let refusal = match has_parameter(operation, |_, place| *place == ParameterIn::Query) {
        true => "A query parameter cannot be used",
        false => "This operation has no query parameters",
    };
    refuse(operation, "400", refusal);
    if has_parameter(operation, |name, _| name == "wait") {
        refuse(operation, "503", "Too many clients wait for news of jobs");
    }
    if has_parameter(operation, |name, _| name == IDEMPOTENCY_KEY) {
        refuse(
            operation,
            "409",
            "A submission under the same Idempotency-Key is under way",
        );
        refuse(
            operation,
            "410",
            "What was submitted under this Idempotency-Key has been deleted",
        );
    }
}

/// Every body may come too slowly, be too large, or not fit on the disk.
fn describe_body(operation: &mut Operation) {
    if operation.request_body.is_some() {
        refuse(operation, "408", "The body came too slowly");
        refuse(operation, "413", "Larger than the server accepts");
        refuse(operation, "507", "The disk of the server is full");
    }
}

/// Conditional requests where there is an entity tag, and the headers of what was begun or made.
fn describe_success(path: &str, operation: &mut Operation) {
    let makes = operation.request_body.is_some() && path != "/evaluations";
    let responses = &mut operation.responses.responses;
    for (status, response) in responses.iter_mut() {
        let RefOr::T(response) = response else {
            continue;
        };
        if status == "202" {
            let description = "Seconds until it is worth a look";
            add_header(response, "Retry-After", seconds(), description);
        }
        if makes && status.starts_with('2') {
            let address = ObjectBuilder::new().schema_type(Type::String);
            add_header(
                response,
                "Location",
                address,
                "The address of what was made",
            );
        }
    }
    if let Some(RefOr::T(found)) = responses.get("200")
        && found.headers.contains_key("ETag")
    {
        refuse(operation, "304", "The client has it already");
    }
}

/// The answers of the layers before a guarded route.
fn describe_access(operation: &mut Operation) {
    let key = SecurityRequirement::new("api_key", Vec::<String>::new());
    // Either will do: without keys, anyone may call.
    operation.security = Some(vec![key, SecurityRequirement::default()]);
    refuse(
        operation,
        "401",
        "Where keys are on: no API key, or one that is unknown, expired or revoked",
    );
    refuse(
        operation,
        "429",
        "Too many requests, or a quota of the key is used up",
    );
    let offered: Vec<String> = ["200", "202"]
        .iter()
        .find_map(|status| match operation.responses.responses.get(*status) {
            Some(RefOr::T(response)) => Some(response.content.keys().cloned().collect()),
            _ => None,
        })
        .unwrap_or_default();
    if !offered.is_empty() {
        let offered = offered.join(" nor ");
        refuse(
            operation,
            "406",
            format!("The client does not accept {offered}"),
        );
    }
}

fn has_parameter(operation: &Operation, is: impl Fn(&str, &ParameterIn) -> bool) -> bool {
    let parameters = operation.parameters.iter().flatten();
    parameters
        .filter_map(|parameter| match parameter {
            RefOr::T(parameter) => Some(parameter),
            RefOr::Ref(_) => None,
        })
        .any(|parameter| is(&parameter.name, &parameter.parameter_in))
}

/// Adds a response unless the operation describes it itself.
fn refuse(operation: &mut Operation, status: &str, description: impl Into<String>) {
    let responses = &mut operation.responses.responses;
    responses.entry(status.to_owned()).or_insert_with(|| {
        let response = ResponseBuilder::new().description(description);
        response.build().into()
    });
}

/// Adds a header unless the response describes it itself.
pub fn add_header(response: &mut Response, name: &str, kind: ObjectBuilder, description: &str) {
    response.headers.entry(name.to_owned()).or_insert_with(|| {
        let mut header = Header::new(kind.build());
        header.description = Some(description.to_owned());
        header.into()
    });
}

fn seconds() -> ObjectBuilder {
    ObjectBuilder::new()
        .schema_type(Type::Integer)
        .format(Some(SchemaFormat::KnownFormat(KnownFormat::Int64)))
        .minimum(Some(0))
}
