//! Files of other formats that the service makes of meshes and of the results of jobs.
//!
//! | file | subject |
//! |---|---|
//! | `table.rs` | all exports: name, media type, what each needs, and the function that writes it |
//! | `surface.rs` | the surface that is exported, the whole or a coarser one |
//! | `glb.rs` | the container of glTF 2.0: nodes, meshes, materials, their bytes |
//! | `mesh.rs` | a mesh as GLB, STL or PLY |
//! | `solids.rs`, `grasp.rs` | arrows and cones as triangles; a grasp as GLB |
//! | `csv.rs` | contacts and history as tables |
//! | `pose.rs`, `isaac.rs`, `moveit.rs` | two contacts as the pose of a gripper, and its files |

mod csv;
mod glb;
mod grasp;
mod isaac;
mod mesh;
mod moveit;
mod pose;
#[cfg(test)]
mod samples;
mod solids;
mod surface;
mod table;

pub use mesh::{EXPORT_FORMATS, ExportFormat, mesh};
pub use pose::PoseError;
pub use surface::{MAX_BUDGET, MIN_BUDGET};
pub use table::{EXPORTS, Export, ExportError, JobSource, MeshSource, Options, Parameter, Writer};
