//! One planning run: validated settings and a mesh in, the best grasp found and its proof out.

use std::ops::ControlFlow;

use nalgebra::Point3;

use super::contact::ContactModel;
use super::mesh::{Candidate, Mesh};
use super::search::{GeneticSettings, InitialMode};
use super::wrench::{EdgeNorm, TorqueScale};

/// What to plan. Every field is validated before it gets here.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Number of contacts m, 1 to [`super::contact::MAX_CONTACTS`].
    pub contacts: usize,
    pub contact_model: ContactModel,
    pub edge_norm: EdgeNorm,
    pub torque_scale: TorqueScale,
    /// Torques are taken about this point; `None` means the mesh's centre of mass.
    pub center_of_mass: Option<Point3<f64>>,
    pub initial: InitialMode,
    pub genetic: GeneticSettings,
    /// Stop after this many quality evaluations.
    pub evaluation_limit: Option<u64>,
    /// Stop once this quality is reached.
    pub target_quality: Option<f64>,
    pub seed: u64,
}
