//! Which candidates a run searches when its request leaves that open.

use crate::core::mesh::{EVEN_RATIO, Report};
use crate::core::plan;
use crate::wire::{
    CandidateKind, CandidateSettings, CandidateSource, Method, PlanRequest, UNIFORM_COUNT,
};

/// Triangles of which fewer are too coarse a choice of places.
const FEW: usize = 1000;

/// The candidates, and what is told of them.
pub(super) fn source(
    report: &Report,
    request: &PlanRequest,
) -> (plan::CandidateSource, CandidateSource) {
    let (settings, because) = match request.candidates {
        Some(settings) => (settings, "as asked for".to_owned()),
        None => chosen(report, request.method),
    };
    let (source, count) = match settings.kind {
        CandidateKind::Triangles => (plan::CandidateSource::Triangles, report.candidates),
        CandidateKind::Uniform => {
            let count = settings.count.unwrap_or(UNIFORM_COUNT) as usize;
            (plan::CandidateSource::Uniform { count }, count)
        }
    };
    let told = CandidateSource {
        kind: settings.kind,
        count: count as u64,
        because,
    };
    (source, told)
}

fn chosen(report: &Report, method: Method) -> (CandidateSettings, String) {
    let triangles = CandidateSettings {
        kind: CandidateKind::Triangles,
        count: None,
    };
    let uniform = CandidateSettings {
        kind: CandidateKind::Uniform,
        count: Some(UNIFORM_COUNT),
    };
    let ratio = report.area_ratio;
    if method != Method::Memetic {
        (
            triangles,
            "this method is told of with triangles".to_owned(),
        )
    } else if ratio > EVEN_RATIO {
        let because = format!(
            "the areas of the triangles vary by a factor of {ratio:.3} (95th over 5th percentile), more than \
             {EVEN_RATIO}"
        );
        (uniform, because)
    } else if report.candidates < FEW {
        let because = format!("there are fewer than {FEW} triangles");
        (uniform, because)
    } else {
        (
            triangles,
            "there are enough triangles, and they are even".to_owned(),
        )
    }
}
