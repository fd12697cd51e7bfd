//! Which candidates a run searches when its request leaves that open.

use crate::wire::{
    CandidateKind, CandidateSource, ContactModel, Method, PlanRequest, Problem, UNIFORM_COUNT,
};
use graspd_core::Interrupt;
use graspd_core::mesh::{EVEN_RATIO, Mesh};
use graspd_core::plan;
use graspd_core::search::{self, Impossible, impossible};

/// Triangles of which fewer are too coarse a choice of places.
const FEW: usize = 1000;

/// The candidates, and what is told of them.
///
/// Fails as the wrenches of the mesh would: see [`plan::WrenchSettings::model`].
pub(super) fn source(
    mesh: &Mesh,
    wrench: &plan::WrenchSettings,
    request: &PlanRequest,
) -> Result<(plan::CandidateSource, CandidateSource), Problem> {
    let report = mesh.report();
    let (kind, because) = match request.candidates {
        Some(settings) => (settings.kind, "as asked for".to_owned()),
        None => chosen(mesh, wrench, request)?,
    };
    let given = request.candidates.and_then(|settings| settings.count);
    let (source, count) = match kind {
        CandidateKind::Triangles => (plan::CandidateSource::Triangles, report.candidates),
        CandidateKind::Uniform => {
            let count = given.unwrap_or(UNIFORM_COUNT) as usize;
            (plan::CandidateSource::Uniform { count }, count)
        }
    };
    let told = CandidateSource {
        kind,
        count: count as u64,
        because,
    };
    Ok((source, told))
}

fn chosen(
    mesh: &Mesh,
    wrench: &plan::WrenchSettings,
    request: &PlanRequest,
) -> Result<(CandidateKind, String), Problem> {
    let report = mesh.report();
    let ratio = report.area_ratio;
    let because = if request.method != Method::Memetic {
        let because = "the places that this method was published with";
        return Ok((CandidateKind::Triangles, because.to_owned()));
    } else if ratio > EVEN_RATIO {
        format!(
            "the areas of the triangles vary by a factor of {ratio:.3} (95th over 5th percentile), more than \
             {EVEN_RATIO}"
        )
    } else if report.candidates < FEW {
        format!("there are fewer than {FEW} triangles")
    } else {
        let because = "there are enough triangles, and they are even";
        return Ok((CandidateKind::Triangles, because.to_owned()));
    };
    if request.contact_model == ContactModel::Frictionless && is_round(mesh, wrench, request)? {
        let because = "the normals at the centroids of all triangles leave a motion free, as on a body of \
                       revolution, whose facets are none of its own";
        return Ok((CandidateKind::Triangles, because.to_owned()));
    }
    Ok((CandidateKind::Uniform, because))
}

/// Whether contacts without friction at the centroids of all triangles leave the body a motion.
fn is_round(
    mesh: &Mesh,
    wrench: &plan::WrenchSettings,
    request: &PlanRequest,
) -> Result<bool, Problem> {
    let model = wrench.model(mesh)?;
    let Some(problem) = search::Problem::new(mesh.candidates(), model, request.contacts as usize)
    else {
        return Ok(false);
    };
    let proof = impossible(&problem, Interrupt::never()).ok().flatten();
    Ok(matches!(proof, Some(Impossible::Deficient { .. })))
}
