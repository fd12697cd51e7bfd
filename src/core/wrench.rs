//! Forces and torques as points of a 6-D space.

use nalgebra::Vector6;

/// (f; λ·(p−c)×f): force, then torque scaled by λ so that both share one unit.
pub type Wrench = Vector6<f64>;

/// The factor λ (1/length) that makes torques comparable with forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TorqueScale {
    /// 1/max‖v−c‖ over the mesh's vertices v: ε becomes free of units.
    MaxRadius,
    /// 1, the paper as written.
    None,
    /// A finite positive number, 1/length.
    Custom(f64),
}

/// How long the edges of a linearised friction cone are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeNorm {
    /// Unit vectors (the paper, eq. 3).
    UnitEdge,
    /// Unit normal component: n + μt (GraspIt!, Dex-Net).
    UnitNormal,
}
