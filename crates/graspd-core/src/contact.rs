//! How a finger touches the body.

use nalgebra::{Point3, UnitVector3};

use super::mesh::{Candidate, SurfaceContact};

/// Most contacts a grasp may have.
pub const MAX_CONTACTS: usize = 64;

/// A finger tip on the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(utoipa::ToSchema))]
#[cfg_attr(feature = "schema", schema(as = ProgressContact))]
pub struct Contact {
    /// Position in the mesh's frame and unit.
    #[cfg_attr(feature = "schema", schema(value_type = [f64; 3]))]
    pub position: Point3<f64>,
    /// Unit normal pointing into the body.
    #[cfg_attr(feature = "schema", schema(value_type = [f64; 3]))]
    pub normal: UnitVector3<f64>,
}

/// A contact and the triangle that it touches, counted from 0 in the order of the file; `None` for one that
/// is where it is whatever the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Site {
    pub contact: Contact,
    pub triangle: Option<u32>,
}

impl From<&Candidate> for Site {
    fn from(candidate: &Candidate) -> Self {
        Self {
            contact: candidate.into(),
            triangle: Some(candidate.triangle),
        }
    }
}

impl From<&Candidate> for Contact {
    fn from(candidate: &Candidate) -> Self {
        Self {
            position: candidate.position,
            normal: candidate.normal,
        }
    }
}

impl From<&SurfaceContact> for Contact {
    fn from(place: &SurfaceContact) -> Self {
        Self {
            position: place.position,
            normal: place.normal,
        }
    }
}

/// Coulomb's coefficient of friction μ: finite and positive.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Friction(f64);

impl Friction {
    /// Greatest coefficient accepted; rubber on rough stone stays below 2.
    pub const MAX: f64 = 10.0;

    /// `None` unless `0 < mu <= Friction::MAX`.
    pub fn new(mu: f64) -> Option<Self> {
        (mu > 0.0 && mu <= Self::MAX).then_some(Self(mu))
    }

    pub fn get(self) -> f64 {
        self.0
    }
}

/// Number of edges r of the pyramid that stands in for the friction cone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConeEdges(u32);

impl ConeEdges {
    pub const MIN: u32 = 3;
    pub const MAX: u32 = 32;

    /// `None` unless `ConeEdges::MIN <= r <= ConeEdges::MAX`.
    pub fn new(r: u32) -> Option<Self> {
        (Self::MIN..=Self::MAX).contains(&r).then_some(Self(r))
    }

    pub fn get(self) -> u32 {
        self.0
    }
}

/// How the friction cone enters the computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cone {
    /// A pyramid with so many edges, inscribed (paper, eqs. 2-4).
    Pyramid(ConeEdges),
    /// The cone itself, through its support function.
    Round,
}

/// Torsional friction μ_t of a soft finger: greatest torque about the normal over normal force.
/// A length, in the mesh's unit; finite and positive.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Torsion(f64);

impl Torsion {
    /// `None` unless `length` is finite and positive.
    pub fn new(length: f64) -> Option<Self> {
        (length > 0.0 && length.is_finite()).then_some(Self(length))
    }

    pub fn get(self) -> f64 {
        self.0
    }
}

/// The force a contact can pass on to the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactModel {
    /// Along the inward normal only.
    Frictionless,
    /// A point contact with Coulomb friction: ‖f_t‖ ≤ μ f_n.
    Hard { friction: Friction, cone: Cone },
    /// A hard contact that also passes on a torque m about the normal, with the elliptic limit
    /// (‖f_t‖/μ)² + (m/μ_t)² ≤ f_n² (Howe & Cutkosky 1996). Its pyramid has the edges of the hard
    /// contact and two more with nothing but torque besides the normal force.
    Soft {
        friction: Friction,
        torsion: Torsion,
        cone: Cone,
    },
}

impl ContactModel {
    /// Primitive wrenches of one contact; `None` when its cone is round and has no edges.
    pub fn wrenches_per_contact(&self) -> Option<usize> {
        match self {
            Self::Frictionless => Some(1),
            Self::Hard { cone, .. } => cone.edges(),
            Self::Soft { cone, .. } => cone.edges().map(|edges| edges + 2),
        }
    }

    /// The same contact with `cone` in the place of its own; a frictionless one has none.
    pub fn with_cone(self, cone: Cone) -> Self {
        match self {
            Self::Frictionless => self,
            Self::Hard { friction, .. } => Self::Hard { friction, cone },
            Self::Soft {
                friction, torsion, ..
            } => Self::Soft {
                friction,
                torsion,
                cone,
            },
        }
    }

    /// Whether the cone is round.
    pub fn is_round(&self) -> bool {
        self.wrenches_per_contact().is_none()
    }
}

impl Cone {
    /// Number of edges of a pyramid.
    pub fn edges(self) -> Option<usize> {
        match self {
            Self::Pyramid(edges) => Some(edges.get() as usize),
            Self::Round => None,
        }
    }
}
