//! How wrenches are made on one mesh.

use std::ops::RangeInclusive;

use nalgebra::Point3;

use crate::contact::{Cone, ConeEdges, ContactModel, Friction, Torsion};
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WrenchSettings {
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub contact: ContactSettings,
    pub edge_norm: EdgeNorm,
    #[cfg_attr(feature = "serde", serde(default, rename = "wrench_space"))]
    pub space: WrenchSpace,
    pub torque_scale: TorqueScale,
    /// Torques are taken about this point; `None` means the mesh's centre of mass.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub center_of_mass: Option<Point3<f64>>,
}

/// A contact model whose torsional friction may follow from the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(into = "ContactFields", try_from = "ContactFields")
)]
pub enum ContactSettings {
    Known(ContactModel),
    /// A soft finger with μ_t = [`TORSION_SHARE`] of the radius of the mesh.
    Soft {
        friction: Friction,
        cone: Cone,
    },
}

/// How a finger touches the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "schema", schema(as = ContactModel))]
pub enum ContactKind {
    /// Pushes along the inward normal only.
    Frictionless,
    /// A point contact with Coulomb friction.
    Hard,
    /// A hard contact that also resists torques about its normal, by an elliptic limit.
    Soft,
}

/// [`ContactSettings`] as separate numbers, the way requests and results have them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactFields {
    pub contact_model: ContactKind,
    /// Absent when frictionless.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub friction: Option<f64>,
    /// Edges of the pyramid in place of the friction cone, 0 for the round cone; absent when frictionless.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub cone_edges: Option<u32>,
    /// Only of soft contacts; absent where it follows from the mesh.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub torsional_friction: Option<f64>,
}

/// The field that a contact model lacks, or that is out of range for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{0} is missing or out of range for this contact model")]
pub struct ContactFault(pub &'static str);

impl From<ContactSettings> for ContactFields {
    fn from(settings: ContactSettings) -> Self {
        let of = |contact_model, friction: Friction, cone: Cone| Self {
            contact_model,
            friction: Some(friction.get()),
            cone_edges: Some(cone.edges().map_or(0, |edges| edges as u32)),
            torsional_friction: None,
        };
        match settings {
            ContactSettings::Known(ContactModel::Frictionless) => Self {
                contact_model: ContactKind::Frictionless,
                friction: None,
                cone_edges: None,
                torsional_friction: None,
            },
            ContactSettings::Known(ContactModel::Hard { friction, cone }) => {
                of(ContactKind::Hard, friction, cone)
            }
            ContactSettings::Known(ContactModel::Soft {
                friction,
                torsion,
                cone,
            }) => Self {
                torsional_friction: Some(torsion.get()),
                ..of(ContactKind::Soft, friction, cone)
            },
            ContactSettings::Soft { friction, cone } => of(ContactKind::Soft, friction, cone),
        }
    }
}

impl TryFrom<ContactFields> for ContactSettings {
    type Error = ContactFault;

    fn try_from(fields: ContactFields) -> Result<Self, ContactFault> {
        if fields.contact_model == ContactKind::Frictionless {
            return Ok(Self::Known(ContactModel::Frictionless));
        }
        let friction = fields.friction.and_then(Friction::new);
        let friction = friction.ok_or(ContactFault("friction"))?;
        let cone = match fields.cone_edges {
            Some(0) => Some(Cone::Round),
            edges => edges.and_then(ConeEdges::new).map(Cone::Pyramid),
        };
        let cone = cone.ok_or(ContactFault("cone_edges"))?;
        Ok(match (fields.contact_model, fields.torsional_friction) {
            (ContactKind::Soft, Some(length)) => {
                let torsion = Torsion::new(length).ok_or(ContactFault("torsional_friction"))?;
                Self::Known(ContactModel::Soft {
                    friction,
                    torsion,
                    cone,
                })
            }
            (ContactKind::Soft, None) => Self::Soft { friction, cone },
            _ => Self::Known(ContactModel::Hard { friction, cone }),
        })
    }
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
