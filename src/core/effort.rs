//! The least contact forces that resist an external wrench.

use nalgebra::Vector3;

/// A wrench that acts on the body from outside, in the mesh's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct External {
    /// In any unit of force; the contact forces come in the same.
    pub force: Vector3<f64>,
    /// About the centre of mass, in that unit times the mesh's unit of length; not scaled by λ.
    pub torque: Vector3<f64>,
}

/// What one finger exerts on the body, in the mesh's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// In the unit of the external force.
    pub force: Vector3<f64>,
    /// Torque about the inward normal, in that unit times the mesh's unit of length; zero but for
    /// soft fingers.
    pub torsion: f64,
}

/// Contact forces that balance an external wrench with the least sum of normal forces.
#[derive(Debug, Clone, PartialEq)]
pub struct Effort {
    /// One per contact, in their order.
    pub forces: Vec<ContactForce>,
    /// Sum of the normal forces, in the unit of the external force.
    pub total: f64,
}
