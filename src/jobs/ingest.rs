//! Reads an uploaded mesh, and checks whether a request can be planned on it.

use std::time::{Duration, Instant};

use crate::run;
use crate::wire::{MeshOptions, PlanRequest, Problem, SurfaceSettings};
use graspd_core::mesh::Mesh;
use graspd_core::plan::{CandidateSource, Method, Mismatch};
use graspd_core::{Interrupt, Interrupted};
use graspd_mesh_io::{Limits, MeshFormat, ReadError, read_interruptible};

/// Limits on reading a mesh file.
#[derive(Debug, Clone, Copy)]
pub struct IngestLimits {
    pub mesh: Limits,
    /// Longest time that reading may take.
    pub time: Duration,
}

/// Reads and prepares a mesh. Blocks; takes about a second for a million triangles.
///
/// The problem is a 415 for a file in no supported format and a 422 for a mesh that cannot be used.
pub fn prepare_mesh(
    bytes: Vec<u8>,
    options: &MeshOptions,
    limits: &IngestLimits,
) -> Result<(MeshFormat, Mesh), Problem> {
    let begun = Instant::now();
    let ask = || (begun.elapsed() >= limits.time).then_some(Interrupted::TimeLimit);
    let interrupt = Interrupt::new(&ask);
    let (format, mut raw) = read_interruptible(&bytes, options.format, &limits.mesh, interrupt)
        .map_err(|error| match error {
            ReadError::NotAMesh { .. } => Problem::new(
                415,
                "unsupported-mesh",
                "Not a mesh in a supported format",
                error.to_string(),
            ),
            ReadError::Malformed { .. }
            | ReadError::TooLarge { .. }
            | ReadError::NoTriangles
            | ReadError::PointCloud { .. }
            | ReadError::Interrupted(_) => unusable(&error),
        })?;
    // File and mesh need not be in memory at the same time as what preparing takes.
    drop(bytes);
    raw.scale(options.scale);
    let mesh = Mesh::prepare(raw).map_err(|error| unusable(&error))?;
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

/// Refuses a request that cannot be planned on a mesh with so many triangles to touch, as it has too few candidates, or
/// several bodies of which none is chosen.
pub fn check_fit(request: &PlanRequest, triangles: u64, bodies: u64) -> Result<(), Problem> {
    if request.surface.component.is_none() {
        run::refuse_several(bodies)?;
    }
    if request.surface != SurfaceSettings::default() {
        // Which triangles there are is only known once the mesh is loaded.
        return Ok(());
    }
    let candidates = match (request.candidates, request.method) {
        (Some(CandidateSource::Uniform { count }), _) => count as u64,
        // Where there are too few, the memetic search spreads more.
        (None, Method::Memetic) => return Ok(()),
        _ => triangles,
    };
    let constraints = request.constraints.as_ref();
    let fixed = constraints.map_or(0, |constraints| constraints.fixed_contacts.len());
    let planned = u64::from(request.contacts).saturating_sub(fixed as u64);
    if planned <= candidates {
        return Ok(());
    }
    Err(Problem::from(Mismatch::TooFewCandidates {
        contacts: request.contacts as usize,
        candidates: candidates as usize,
    }))
}
