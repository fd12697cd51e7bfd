//! Bodies and grasps in the formats of other programs.
//!
//! | file | subject |
//! |---|---|
//! | `body.rs` | the surface that is exported, the whole or a coarser one |
//! | `glb.rs` | the container of glTF 2.0: nodes, meshes, materials, their bytes |
//! | `mesh.rs` | a mesh as GLB, STL or PLY |
//! | `solids.rs`, `grasp.rs` | arrows and cones as triangles; a grasp as GLB |
//! | `csv.rs` | contacts and history as tables |
//! | `gripper.rs` | two contacts as the pose of a gripper |

mod body;
mod csv;
mod glb;
mod grasp;
mod gripper;
mod mesh;
#[cfg(test)]
mod samples;
mod solids;

pub use body::{Body, MAX_BUDGET, MIN_BUDGET};
pub use csv::{contacts_csv, history_csv};
pub use grasp::grasp_glb;
pub use gripper::{Gripper, NoGripper};
pub use mesh::{ExportFormat, mesh};
