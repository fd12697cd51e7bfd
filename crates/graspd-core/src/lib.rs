//! The planner itself: pure functions over validated values.
//!
//! Data flows one way: `random → mesh → contact → constraints, wrench → quality → search → plan` for what is sought, and
//! `quality → measures, motion, effort → evaluation` and `search → robustness, independent, task → analysis`
//! for what is given; a module uses only those to its left. Nothing here reads a file, a clock or a global,
//! and every random number comes from an explicit seed. Lengths are in the mesh's own unit, normals point
//! INTO the body, wrenches are taken about the centre of mass.

#![forbid(unsafe_code)]

pub mod analysis;
mod blocks;
pub mod constraints;
pub mod contact;
pub mod diverse;
pub mod effort;
pub mod evaluation;
pub mod independent;
mod interrupt;
mod max_resistible;
pub mod measures;
pub mod mesh;
mod mismatch;
pub mod motion;
pub mod plan;
pub mod quality;
mod random;
pub mod robustness;
pub mod search;
pub mod task;
mod torque_scale;
pub mod wrench;

pub use interrupt::{Interrupt, Interrupted};
