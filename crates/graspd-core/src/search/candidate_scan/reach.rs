//! How far the cone of one contact reaches along a direction, in the terms of a contact model.

use super::lanes::Singles;
use crate::contact::{Cone, ContactModel};
use crate::wrench::{STAND_IN_EDGES, WrenchModel, WrenchSpace};

/// Rounding of a reach in single precision over the longest wrench: some twelve roundings of 2⁻²⁴ in three
/// components, twice that for safety.
const ROUNDING: f64 = 3e-6;

/// The tangential part of a friction cone.
#[derive(Debug, Clone)]
pub(super) enum Tangential {
    /// Frictionless: the normal only.
    None,
    /// Pyramid and torsion: the greater of both. Edges are at the angles whose cosine and sine, times μ,
    /// are given; the others mirror them.
    Edges {
        edges: Vec<[f32; 2]>,
        /// Whether the mirror image of an edge across the second tangent is an edge too.
        even: bool,
        torsion: f32,
    },
    /// Circle or ellipsoid: μ and torsion.
    Round { friction: f32, torsion: f32 },
}

/// The numbers of a contact model that bounds are made of.
#[derive(Debug, Clone)]
pub(super) struct ReachModel {
    pub tangential: Tangential,
    /// μ, and μ_t λ: they bound the tangential part of a whole block.
    pub friction: f32,
    pub torsion: f32,
    /// Normal component of an edge.
    length: f32,
    /// Lowest reach that counts: zero where a finger may push with no force at all.
    floor: f32,
    /// Greatest error of a reach in single precision.
    pub slack: f64,
}

impl ReachModel {
    /// The numbers of a model for grasps of `contacts` fingers whose lever arms, times λ, are at most `longest_lever`.
    pub fn new(model: &WrenchModel, longest_lever: f64, contacts: usize) -> Self {
        let (tangential, length, friction, torsion) = tangential(model);
        // The others' reach is rounded too where it is added.
        let added = 1.0 + contacts as f64 / 32.0;
        Self {
            tangential,
            friction: friction as f32,
            torsion: torsion as f32,
            length: length as f32,
            floor: match model.space {
                WrenchSpace::L1 => f32::NEG_INFINITY,
                WrenchSpace::Linf => 0.0,
            },
            slack: ROUNDING * (1.0 + longest_lever) * length * (1.0 + friction + torsion) * added,
        }
    }

    /// Scales reaches to the length of the edges and adds the reach of the other fingers.
    #[inline(always)]
    pub fn raised(&self, reach: Singles, base: f32) -> Singles {
        let (length, floor) = (self.length, self.floor);
        reach.map(|reach| {
            let reach = reach * length;
            base + if reach > floor { reach } else { floor }
        })
    }
}

/// Returns the tangential part, the normal component of an edge, μ, and μ_t λ.
fn tangential(model: &WrenchModel) -> (Tangential, f64, f64, f64) {
    let (friction, torsion, cone) = match model.contact_model {
        ContactModel::Frictionless => return (Tangential::None, 1.0, 0.0, 0.0),
        ContactModel::Hard { friction, cone } => (friction, 0.0, cone),
        ContactModel::Soft {
            friction,
            torsion,
            cone,
        } => (friction, torsion.get() * model.torque_scale, cone),
    };
    let length = model.edge_length(friction);
    let mu = friction.get();
    let tangential = match cone {
        Cone::Round => Tangential::Round {
            friction: mu as f32,
            torsion: torsion as f32,
        },
        Cone::Pyramid(_) => {
            let count = cone.edges().unwrap_or(STAND_IN_EDGES);
            let even = count.is_multiple_of(2);
            // Mirrored across the first tangent, and across the second where the count is even: the rest is implied.
            let last = if even { count / 4 } else { count / 2 };
            let edges = (0..=last).map(|j| {
                let (sin, cos) = (std::f64::consts::TAU * j as f64 / count as f64).sin_cos();
                [(mu * cos) as f32, (mu * sin) as f32]
            });
            Tangential::Edges {
                edges: edges.collect(),
                even,
                torsion: torsion as f32,
            }
        }
    };
    (tangential, length, mu, torsion)
}
