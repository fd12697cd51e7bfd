//! What every operation may answer when it refuses.

use serde_json::Value;
use utoipa::openapi::security::SecurityRequirement;
use utoipa::openapi::{
    ContentBuilder, Header, ObjectBuilder, OpenApi, Ref, RefOr, Response, ResponseBuilder, Type,
};

use super::operations;
use crate::http::error::{Error, PROBLEM_JSON};
use crate::http::rate::Standing;
use crate::jobs;
use crate::wire::Problem;

/// Says of routes before which the gate stands what the gate may ask and answer.
pub fn describe_guard(api: &mut OpenApi) {
    let key = SecurityRequirement::new("api_key", Vec::<String>::new());
    for operation in operations(api) {
        // Either will do: keys are off where the operator wants it so.
        operation.security = Some(vec![key.clone(), SecurityRequirement::default()]);
        let answers = [
            (
                "401",
                "Where keys are on: no API key, or one that is unknown, expired or revoked",
            ),
            ("429", "Too many requests, or a quota of the key is used up"),
        ];
        for (status, description) in answers {
            let responses = &mut operation.responses.responses;
            responses.insert(status.to_owned(), described(description));
        }
    }
}

/// Says of every error response that it is a problem, with an example of one and the headers that come
/// along, so that no handler has to; adds what any operation may answer.
pub fn describe_errors(api: &mut OpenApi) {
    for operation in operations(api) {
        let responses = &mut operation.responses.responses;
        let answers = [
            (
                "500",
                "A fault of the server; its log tells more under the id in the detail",
            ),
            ("503", "The service cannot do this now"),
        ];
        for (status, description) in answers {
            responses
                .entry(status.to_owned())
                .or_insert_with(|| described(description));
        }
        for (status, response) in responses {
            if let RefOr::T(response) = response
                && status.starts_with(['4', '5'])
            {
                let problem = ContentBuilder::new()
                    .schema(Some(Ref::from_schema_name("Problem")))
                    .example(example(status));
                response
                    .content
                    .insert(PROBLEM_JSON.to_owned(), problem.build().into());
                describe_headers(status, response);
            }
        }
    }
}

fn described(description: &str) -> RefOr<Response> {
    ResponseBuilder::new()
        .description(description)
        .build()
        .into()
}

fn describe_headers(status: &str, response: &mut Response) {
    let headers: &[(&str, Type, &str)] = match status {
        "401" => &[("WWW-Authenticate", Type::String, "Names the scheme, Bearer")],
        "429" => &[
            (
                "Retry-After",
                Type::Integer,
                "Seconds until it is worth another try",
            ),
            (
                "RateLimit",
                Type::String,
                "What is left (r), and seconds until there is more (t)",
            ),
            (
                "RateLimit-Policy",
                Type::String,
                "How many (q) in how many seconds (w)",
            ),
        ],
        "503" => &[(
            "Retry-After",
            Type::Integer,
            "Seconds until it is worth another try",
        )],
        _ => &[],
    };
    for (name, kind, description) in headers {
        let schema = ObjectBuilder::new().schema_type(kind.clone()).build();
        let mut header = Header::new(schema);
        header.description = Some((*description).to_owned());
        response.headers.insert((*name).to_owned(), header.into());
    }
}

/// A problem of this status, in the words that the service has for it.
fn example(status: &str) -> Option<Value> {
    let error: Error = match status {
        "400" => Error::query("limit", "a whole number from 1 to 1000 is wanted"),
        "401" => Error::unauthorized("this API key is unknown, expired or revoked"),
        "404" => Error::not_found(),
        "406" => Error::not_acceptable("application/json"),
        "408" => Error::too_slow(),
        "409" => Error::conflict("this job has not ended yet"),
        "410" => jobs::Error::Gone.into(),
        "413" => Error::too_large("the body may have at most 268435456 bytes"),
        "415" => Error::unsupported(
            "send multipart/form-data with the mesh file, or application/json with mesh_id",
        ),
        "422" => Error::invalid_field("/contacts", "must be a whole number from 1 to 64"),
        "429" => {
            let standing = Standing {
                name: "requests",
                limit: 600,
                left: 0,
                window_s: Some(60),
                reset_s: 1,
            };
            Error::too_many("too many requests; ask less often", standing)
        }
        "500" => Problem::new(
            500,
            "internal-error",
            "Internal error",
            "a fault of the server; its log tells more under the id 6d1c9a2e-5f0b-4a43-9a53-0c5f6b8d2f17",
        )
        .into(),
        "503" => jobs::Error::Draining.into(),
        "507" => Error::disk_full(),
        _ => return None,
    };
    serde_json::to_value(error.problem()).ok()
}
