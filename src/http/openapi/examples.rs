//! Examples of requests and answers, taken from a real run.

use serde_json::{Value, json};
use utoipa::openapi::path::{Operation, ParameterBuilder};
use utoipa::openapi::{OpenApi, RefOr};

use super::operations::operations;

const JSON: &str = "application/json";
/// The example of these is one line.
const NDJSON: &str = "application/x-ndjson";

/// Adds an example wherever JSON goes in or out.
pub fn show_examples(api: &mut OpenApi) {
    let read = |text: &str| serde_json::from_str::<Value>(text).unwrap_or_default();
    let queued = read(include_str!("../../../openapi/examples/job_queued.json"));
    let job = read(include_str!("../../../openapi/examples/job.json"));
    let result = read(include_str!("../../../openapi/examples/result.json"));
    let mesh = read(include_str!("../../../openapi/examples/mesh.json"));
    let evaluations = read(include_str!("../../../openapi/examples/evaluations.json"));
    let batch = read(include_str!("../../../openapi/examples/batch_queued.json"));
    let ended = read(include_str!("../../../openapi/examples/batch.json"));
    let mesh_id = mesh["id"].clone();
    for operation in mesh_operations(api) {
        for parameter in operation.parameters.iter_mut().flatten() {
            if let RefOr::T(parameter) = parameter
                && parameter.name == "id"
            {
                let described = ParameterBuilder::from(parameter.clone());
                *parameter = described.example(Some(mesh_id.clone())).build();
            }
        }
    }
    for (_, operation) in operations(api) {
        let (request, answers) = match operation.operation_id.as_deref().unwrap_or_default() {
            "submit_job" => (
                Some(json!({"mesh_id": mesh_id, "contacts": 4, "friction": 0.5, "seed": 1})),
                vec![("202", queued.clone())],
            ),
            "list_jobs" => (None, vec![("200", json!({"jobs": [queued]}))]),
            "read_job" => (None, vec![("200", job.clone())]),
            "read_result" => (None, vec![("200", result.clone())]),
            "cancel_job" => (None, vec![("200", job.clone()), ("202", queued.clone())]),
            "submit_batch" => (
                Some(
                    json!({"meshes": [mesh_id, mesh_id], "request": {"contacts": 4}, "label": "knights"}),
                ),
                vec![("202", batch.clone())],
            ),
            "list_batches" => (None, vec![("200", json!({"batches": [batch]}))]),
            "read_batch" => (None, vec![("200", ended.clone())]),
            "read_batch_results" => {
                let line = json!({
                    "index": 0, "job_id": job["id"], "mesh_id": mesh_id, "state": "succeeded", "result": result,
                });
                (None, vec![("200", line)])
            }
            "cancel_batch" => (None, vec![("200", ended.clone()), ("202", batch.clone())]),
            "upload_mesh" => (None, vec![("200", mesh.clone()), ("201", mesh.clone())]),
            "list_meshes" => (None, vec![("200", json!({"meshes": [mesh]}))]),
            "read_mesh" => (None, vec![("200", mesh.clone())]),
            "evaluate" => (
                Some(json!({
                    "mesh_id": mesh_id,
                    "grasps": [[{"triangle": 7187}, {"triangle": 10670}, {"triangle": 14040}, {"triangle": 17790}]],
                })),
                vec![("200", evaluations.clone())],
            ),
            "healthz" | "readyz" => (None, vec![("200", json!({"status": "ok"}))]),
            _ => continue,
        };
        show(operation, request, answers);
    }
}

/// Returns the operations that read one mesh.
fn mesh_operations(api: &mut OpenApi) -> impl Iterator<Item = &mut Operation> {
    let paths = api.paths.paths.iter_mut();
    let of_mesh = paths.filter(|(path, _)| path.starts_with("/meshes/{id}"));
    of_mesh.filter_map(|(_, path)| path.get.as_mut())
}

fn show(operation: &mut Operation, request: Option<Value>, answers: Vec<(&str, Value)>) {
    if let Some(RefOr::T(body)) = &mut operation.request_body
        && let Some(RefOr::T(content)) = body.content.get_mut(JSON)
    {
        content.example = request;
    }
    for (status, answer) in answers {
        if let Some(RefOr::T(response)) = operation.responses.responses.get_mut(status) {
            for kind in [JSON, NDJSON] {
                if let Some(RefOr::T(content)) = response.content.get_mut(kind) {
                    content.example = Some(answer.clone());
                }
            }
        }
    }
}
