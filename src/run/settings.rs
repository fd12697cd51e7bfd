//! From a request to the core's settings.

use crate::wire::PlanRequest;
use graspd_core::constraints::Constraints;
use graspd_core::plan::{CandidateSource, Settings};
use graspd_core::search::SearchSettings;

/// Takes every setting of the request but constraints and candidates, which depend on the mesh.
pub(super) fn settings(request: &PlanRequest) -> Settings {
    let &PlanRequest {
        contacts,
        ref quality,
        ref analyses,
        // Chooses the mesh.
        surface: _,
        // Depend on the mesh.
        constraints: _,
        candidates: _,
        method,
        population,
        generations,
        crossover_probability,
        mutation_probability,
        elitism,
        initial,
        time_limit_s: _,
        evaluation_limit,
        target_quality,
        polish,
        // Each is a run of its own.
        trials: _,
        top,
        seed,
        label: _,
        priority: _,
        callback_url: _,
    } = request;
    Settings {
        contacts: contacts as usize,
        wrench: quality.wrench,
        method,
        candidates: CandidateSource::Triangles,
        constraints: Constraints::default(),
        polish,
        top: top as usize,
        initial,
        search: SearchSettings {
            population: population as usize,
            generations: generations as usize,
            crossover_probability,
            mutation_probability,
            elitism: elitism as usize,
            target_quality,
        },
        evaluation_limit,
        analysis: analyses.clone(),
        seed,
    }
}
