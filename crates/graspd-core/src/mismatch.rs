//! Why a mesh and settings, each valid by itself, do not fit together.

/// How far from the mesh torques may be taken about, in radii of the mesh. Farther out the torque of
/// a contact is all but its force, and the wrenches lose the digits that tell them apart.
pub const FARTHEST_CENTER: f64 = 100.0;

/// Why mesh and settings do not fit together.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Mismatch {
    #[error(
        "{contacts} contacts need as many places to put them, but the mesh has only {candidates} \
         candidates; ask for fewer contacts or send a finer mesh"
    )]
    TooFewCandidates { contacts: usize, candidates: usize },
    #[error(
        "center_of_mass is {radii:.0} times the size of the mesh away from it, more than \
         {FARTHEST_CENTER}; give it in the frame and unit of the mesh"
    )]
    FarCenter { radii: f64 },
    #[error(
        "torque_scale makes torques {product:e} times as large as forces; times the size of the \
         mesh it must be from 1e-6 to 1e6"
    )]
    TorqueScale { product: f64 },
    #[error(
        "torsional_friction is {product:e} times the size of the mesh; it is a length in the unit of \
         the mesh, from 1e-6 to 1000 times that size"
    )]
    Torsion { product: f64 },
    #[error(
        "sigma is {radii:.3} times the size of the mesh; it is a length in the unit of the mesh, at most \
         its size"
    )]
    Sigma { radii: f64 },
}
