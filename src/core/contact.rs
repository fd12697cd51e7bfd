//! How a finger touches the body.

use nalgebra::{Point3, UnitVector3};

/// Most contacts a grasp may have.
pub const MAX_CONTACTS: usize = 64;

/// A finger tip on the surface. Position in the mesh's frame; normal INTO the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    pub position: Point3<f64>,
    pub normal: UnitVector3<f64>,
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

/// The force a contact can pass on to the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactModel {
    /// Along the inward normal only.
    Frictionless,
    /// A point contact with Coulomb friction, its cone replaced by a pyramid (paper, eqs. 2-4).
    Hard {
        friction: Friction,
        edges: ConeEdges,
    },
}

impl ContactModel {
    /// Primitive wrenches of one contact.
    pub fn wrenches_per_contact(&self) -> usize {
        match self {
            Self::Frictionless => 1,
            Self::Hard { edges, .. } => edges.get() as usize,
        }
    }
}
