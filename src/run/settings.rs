//! From the wire's request to the core's settings.

use nalgebra::Point3;

use super::analyses;
use crate::wire::{self, PlanRequest, Problem, QualitySettings};
use graspd_core::constraints::Constraints;
use graspd_core::contact::{Cone, ConeEdges, ContactModel, Friction, Torsion};
use graspd_core::plan::{CandidateSource, ContactSettings, Method, Settings, WrenchSettings};
use graspd_core::search::{GeneticSettings, InitialMode};
use graspd_core::wrench::{EdgeNorm, TorqueScale, WrenchSpace};

/// Takes every field of the request into account but constraints and candidates, which depend on the mesh. A request that came through the wire's own
/// validation never fails here; one read back from a store that something else wrote to may.
pub(super) fn settings(request: &PlanRequest) -> Result<Settings, Problem> {
    let &PlanRequest {
        contacts,
        // What `quality` takes.
        contact_model: _,
        friction: _,
        cone_edges: _,
        torsional_friction: _,
        edge_norm: _,
        wrench_space: _,
        torque_scale: _,
        center_of_mass: _,
        units: _,
        // What `analyses` takes.
        robustness: _,
        independent_regions: _,
        task_wrenches: _,
        gravity: _,
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
    Ok(Settings {
        contacts: contacts as usize,
        wrench: wrench(&request.quality())?,
        method: match method {
            wire::Method::Memetic => Method::Memetic,
            wire::Method::ModifiedGa => Method::ModifiedGa,
            wire::Method::Local => Method::Local,
            wire::Method::Random => Method::Random,
        },
        candidates: CandidateSource::Triangles,
        constraints: Constraints::default(),
        polish,
        top: top as usize,
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
        analysis: analyses::settings(&request.analyses())?,
        seed,
    })
}

/// The part of it that wrenches depend on; as safe as [`settings`].
pub(super) fn wrench(quality: &QualitySettings) -> Result<WrenchSettings, Problem> {
    let &QualitySettings {
        contact_model,
        friction,
        cone_edges,
        torsional_friction,
        edge_norm,
        wrench_space,
        torque_scale,
        center_of_mass,
        units: _,
    } = quality;
    let friction = || {
        friction
            .and_then(Friction::new)
            .ok_or_else(|| out_of_range("friction"))
    };
    let cone = || {
        let cone = match cone_edges? {
            0 => Cone::Round,
            edges => Cone::Pyramid(ConeEdges::new(edges)?),
        };
        Some(cone)
    };
    let cone = || cone().ok_or_else(|| out_of_range("cone_edges"));
    let contact = match contact_model {
        wire::ContactModel::Frictionless => ContactSettings::Known(ContactModel::Frictionless),
        wire::ContactModel::Hard => ContactSettings::Known(ContactModel::Hard {
            friction: friction()?,
            cone: cone()?,
        }),
        wire::ContactModel::Soft => match torsional_friction {
            Some(length) => ContactSettings::Known(ContactModel::Soft {
                friction: friction()?,
                torsion: Torsion::new(length).ok_or_else(|| out_of_range("torsional_friction"))?,
                cone: cone()?,
            }),
            None => ContactSettings::Soft {
                friction: friction()?,
                cone: cone()?,
            },
        },
    };
    Ok(WrenchSettings {
        contact,
        edge_norm: match edge_norm {
            wire::EdgeNorm::UnitEdge => EdgeNorm::UnitEdge,
            wire::EdgeNorm::UnitNormal => EdgeNorm::UnitNormal,
        },
        space: match wrench_space {
            wire::WrenchSpace::L1 => WrenchSpace::L1,
            wire::WrenchSpace::Linf => WrenchSpace::Linf,
        },
        torque_scale: match torque_scale {
            wire::TorqueScale::MaxRadius => TorqueScale::MaxRadius,
            wire::TorqueScale::None => TorqueScale::None,
            wire::TorqueScale::Custom(value) => TorqueScale::Custom(value),
        },
        center_of_mass: center_of_mass.map(Point3::from),
    })
}

pub(super) fn out_of_range(field: &str) -> Problem {
    Problem::new(
        422,
        "invalid-request",
        "Invalid request",
        format!("{field} is missing or out of range for this contact model."),
    )
}
