//! How wrenches are made on one mesh.

use std::ops::RangeInclusive;

use nalgebra::Point3;

use crate::contact::{Cone, ContactModel, Friction, Torsion};
use crate::mesh::Mesh;
use crate::mismatch::{FARTHEST_CENTER, Mismatch};
use crate::wrench::{EdgeNorm, TorqueScale, WrenchModel, WrenchSpace};

/// Range of the torque scale times the radius of the mesh. Beyond it torques or forces are lost in
/// the rounding of the other.
pub const TORQUE_SCALES: RangeInclusive<f64> = 1e-6..=1e6;

/// Range of a soft finger's torsional friction over the radius of the mesh.
pub const TORSIONS: RangeInclusive<f64> = 1e-6..=1e3;

/// How wrenches are to be made on any mesh; [`WrenchModel`] is the same on one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrenchSettings {
    pub contact: ContactSettings,
    pub edge_norm: EdgeNorm,
    pub space: WrenchSpace,
    pub torque_scale: TorqueScale,
    /// Torques are taken about this point; `None` means the mesh's centre of mass.
    pub center_of_mass: Option<Point3<f64>>,
}

/// A contact model whose torsional friction may follow from the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactSettings {
    Known(ContactModel),
    /// A soft finger with μ_t = [`TORSION_SHARE`] of the radius of the mesh.
    Soft {
        friction: Friction,
        cone: Cone,
    },
}

/// Torsional friction μ_t of a soft finger, unless it is known, over the greatest distance of a vertex
/// from the point torques are taken about: a finger tip whose contact patch is about a tenth as wide as
/// the body.
pub const TORSION_SHARE: f64 = 0.05;

impl WrenchSettings {
    /// The model on one mesh.
    ///
    /// # Errors
    /// When torques would lose the digits that tell wrenches apart; never
    /// [`Mismatch::TooFewCandidates`] or [`Mismatch::Sigma`].
    pub fn model(&self, mesh: &Mesh) -> Result<WrenchModel, Mismatch> {
        let own = mesh.report();
        let center = self.center_of_mass.unwrap_or(own.center_of_mass);
        let radii = (center - own.center_of_mass).norm() / own.bounding_radius;
        if radii > FARTHEST_CENTER {
            return Err(Mismatch::FarCenter { radii });
        }
        let radius = mesh.radius_about(&center);
        let torque_scale = self.torque_scale.value(mesh, &center);
        let product = torque_scale * radius;
        if !TORQUE_SCALES.contains(&product) {
            return Err(Mismatch::TorqueScale { product });
        }
        let contact_model = match self.contact {
            ContactSettings::Known(model) => model,
            ContactSettings::Soft { friction, cone } => {
                let torsion = Torsion::new(TORSION_SHARE * radius);
                match torsion {
                    Some(torsion) => ContactModel::Soft {
                        friction,
                        torsion,
                        cone,
                    },
                    None => ContactModel::Hard { friction, cone },
                }
            }
        };
        if let ContactModel::Soft { torsion, .. } = contact_model {
            let product = torsion.get() / radius;
            if !TORSIONS.contains(&product) {
                return Err(Mismatch::Torsion { product });
            }
        }
        Ok(WrenchModel {
            contact_model,
            edge_norm: self.edge_norm,
            space: self.space,
            center,
            torque_scale,
        })
    }
}
