//! From the wire's request to the core's settings.

use nalgebra::Point3;

use crate::core::contact::{Cone, ConeEdges, ContactModel, Friction};
use crate::core::plan::Settings;
use crate::core::search::{GeneticSettings, InitialMode};
use crate::core::wrench::{EdgeNorm, TorqueScale, WrenchSpace};
use crate::wire::{self, PlanRequest, Problem};

/// Takes every field of the request into account. A request that came through the wire's own
/// validation never fails here; one read back from a store that something else wrote to may.
pub(super) fn settings(request: &PlanRequest) -> Result<Settings, Problem> {
    let &PlanRequest {
        contacts,
        contact_model,
        friction,
        cone_edges,
        edge_norm,
        torque_scale,
        center_of_mass,
        units: _,
        method: wire::Method::ModifiedGa,
        population,
        generations,
        crossover_probability,
        mutation_probability,
        elitism,
        initial,
        time_limit_s: _,
        evaluation_limit,
        target_quality,
        seed,
        label: _,
    } = request;
    Ok(Settings {
        contacts: contacts as usize,
        contact_model: match contact_model {
            wire::ContactModel::Frictionless => ContactModel::Frictionless,
            wire::ContactModel::Hard => ContactModel::Hard {
                friction: friction
                    .and_then(Friction::new)
                    .ok_or_else(|| out_of_range("friction"))?,
                cone: cone_edges
                    .and_then(ConeEdges::new)
                    .map(Cone::Pyramid)
                    .ok_or_else(|| out_of_range("cone_edges"))?,
            },
        },
        edge_norm: match edge_norm {
            wire::EdgeNorm::UnitEdge => EdgeNorm::UnitEdge,
            wire::EdgeNorm::UnitNormal => EdgeNorm::UnitNormal,
        },
        space: WrenchSpace::L1,
        torque_scale: match torque_scale {
            wire::TorqueScale::MaxRadius => TorqueScale::MaxRadius,
            wire::TorqueScale::None => TorqueScale::None,
            wire::TorqueScale::Custom(value) => TorqueScale::Custom(value),
        },
        center_of_mass: center_of_mass.map(Point3::from),
        initial: match initial {
            wire::InitialMode::Weak => InitialMode::Weak,
            wire::InitialMode::Strict => InitialMode::Strict,
        },
        genetic: GeneticSettings {
            population: population as usize,
            generations: generations as usize,
            crossover_probability,
            mutation_probability,
            elitism: elitism as usize,
            evaluation_limit,
            target_quality,
        },
        seed,
    })
}

fn out_of_range(field: &str) -> Problem {
    Problem::new(
        422,
        "invalid-request",
        "Invalid request",
        format!("{field} is missing or out of range for hard contacts."),
    )
}
