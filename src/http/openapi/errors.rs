//! Error responses: the body, an example and the headers of each status.

use serde_json::Value;
use utoipa::openapi::{ContentBuilder, ObjectBuilder, OpenApi, Ref, RefOr, Response, Type};

use super::operations::operations;
use super::rules::add_header;
use crate::http::layers::rate_limit::RateLimitState;
use crate::http::response::error::{Error, PROBLEM_JSON, fault_detail};
use crate::jobs;
use crate::wire::Problem;

/// Completes every error response: it is a problem, with an example of one and the headers that come
/// along.
pub fn describe_problems(api: &mut OpenApi) {
    for (_, operation) in operations(api) {
        for (status, response) in &mut operation.responses.responses {
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

fn describe_headers(status: &str, response: &mut Response) {
    let headers: &[(&str, Type, &str)] = match status {
        "401" => &[("WWW-Authenticate", Type::String, "The scheme, Bearer")],
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
        let kind = ObjectBuilder::new().schema_type(kind.clone());
        add_header(response, name, kind, description);
    }
}

/// Returns a problem of this status, as the service words it.
fn example(status: &str) -> Option<Value> {
    let error: Error = match status {
        "400" => Error::query("limit", "must be a whole number from 1 to 1000"),
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
            let state = RateLimitState {
                name: "requests",
                limit: 600,
                left: 0,
                window_s: Some(60),
                reset_s: 1,
            };
            Error::too_many("too many requests; ask less often", state)
        }
        "500" => Problem::new(
            500,
            "internal-error",
            "Internal error",
            fault_detail(&"6d1c9a2e-5f0b-4a43-9a53-0c5f6b8d2f17"),
        )
        .into(),
        "503" => jobs::Error::Draining.into(),
        "507" => Error::disk_full(),
        _ => return None,
    };
    serde_json::to_value(error.problem()).ok()
}
