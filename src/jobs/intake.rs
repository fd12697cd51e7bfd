//! From the bytes of an upload to a prepared mesh, or to what is wrong with it.

use crate::core::mesh::{Format, Limits, Mesh, ReadError, read};
use crate::wire::{FieldError, PlanRequest, Problem};

/// Reads and prepares a mesh. Blocks; about a second for a million triangles.
///
/// The problem is a 415 for what is no mesh in a supported format and a 422 for one that cannot
/// be used.
pub fn prepare(
    bytes: &[u8],
    format: Option<Format>,
    limits: &Limits,
) -> Result<(Format, Mesh), Problem> {
    let (format, raw) = read(bytes, format, limits).map_err(|error| match error {
        ReadError::NotAMesh { .. } => Problem::new(
            415,
            "unsupported-mesh",
            "Not a mesh in a supported format",
            error.to_string(),
        ),
        ReadError::Malformed { .. } | ReadError::TooLarge { .. } | ReadError::NoTriangles => {
            unusable(&error)
        }
    })?;
    let mesh = Mesh::prepare(raw, format).map_err(|error| unusable(&error))?;
    Ok((format, mesh))
}

fn unusable(error: &dyn std::error::Error) -> Problem {
    Problem::new(
        422,
        "unusable-mesh",
        "The mesh cannot be used",
        error.to_string(),
    )
}

/// Refuses a request that no mesh with so many candidates can serve.
pub fn check_fit(request: &PlanRequest, candidates: u64) -> Result<(), Problem> {
    let contacts = request.contacts;
    if u64::from(contacts) <= candidates {
        return Ok(());
    }
    let detail = format!(
        "{contacts} contacts are asked for, but the mesh has only {candidates} candidates; ask \
         for fewer contacts or send a finer mesh"
    );
    let problem = Problem::new(
        422,
        "too-few-candidates",
        "Too few candidates",
        detail.as_str(),
    );
    Err(problem.with_errors(vec![FieldError {
        pointer: "/contacts".to_owned(),
        detail,
    }]))
}
