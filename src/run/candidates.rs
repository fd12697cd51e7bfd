//! Which candidates a run searches when its request leaves that open.

use crate::wire::settings::UNIFORM_COUNT;
use crate::wire::{CandidateKind, PlanRequest, Problem, SearchedCandidates};
use graspd_core::Interrupt;
use graspd_core::contact::ContactModel;
use graspd_core::mesh::{EVEN_RATIO, Mesh};
use graspd_core::plan::{CandidateSource, ContactSettings, Method, WrenchSettings};
use graspd_core::search::{Impossible, SearchProblem, prove_impossible};

/// Triangles of which fewer are too coarse a choice of places.
const FEW: usize = 1000;

/// The candidates, and how the result describes them.
///
/// # Errors
/// Those of [`WrenchSettings::model`].
pub(super) fn source(
    mesh: &Mesh,
    wrench: &WrenchSettings,
    request: &PlanRequest,
) -> Result<(CandidateSource, SearchedCandidates), Problem> {
    let (source, because) = match request.candidates {
        Some(source) => (source, "as asked for".to_owned()),
        None => chosen(mesh, wrench, request)?,
    };
    let (kind, count) = match source {
        CandidateSource::Triangles => (CandidateKind::Triangles, mesh.report().candidates),
        CandidateSource::Uniform { count } => (CandidateKind::Uniform, count),
    };
    let searched = SearchedCandidates {
        kind,
        count: count as u64,
        because,
    };
    Ok((source, searched))
}

fn chosen(
    mesh: &Mesh,
    wrench: &WrenchSettings,
    request: &PlanRequest,
) -> Result<(CandidateSource, String), Problem> {
    let report = mesh.report();
    let ratio = report.area_ratio;
    let because = if request.method != Method::Memetic {
        let because = "the places that this method was published with";
        return Ok((CandidateSource::Triangles, because.to_owned()));
    } else if ratio > EVEN_RATIO {
        format!(
            "the areas of the triangles vary by a factor of {ratio:.3} (95th over 5th percentile), more than \
             {EVEN_RATIO}"
        )
    } else if report.candidates < FEW {
        format!("there are fewer than {FEW} triangles")
    } else {
        let because = "there are enough triangles, and they are even";
        return Ok((CandidateSource::Triangles, because.to_owned()));
    };
    let is_frictionless = wrench.contact == ContactSettings::Known(ContactModel::Frictionless);
    if is_frictionless && is_round(mesh, wrench, request)? {
        let because = "the normals at the centroids of all triangles leave a motion free, as on a body of \
                       revolution, whose facets are none of its own";
        return Ok((CandidateSource::Triangles, because.to_owned()));
    }
    let count = UNIFORM_COUNT as usize;
    Ok((CandidateSource::Uniform { count }, because))
}

/// Whether contacts without friction at the centroids of all triangles leave the body a motion.
fn is_round(mesh: &Mesh, wrench: &WrenchSettings, request: &PlanRequest) -> Result<bool, Problem> {
    let model = wrench.model(mesh)?;
    let Some(problem) = SearchProblem::new(mesh.candidates(), model, request.contacts as usize)
    else {
        return Ok(false);
    };
    let proof = prove_impossible(&problem, Interrupt::never())
        .ok()
        .flatten();
    Ok(matches!(proof, Some(Impossible::Deficient { .. })))
}
