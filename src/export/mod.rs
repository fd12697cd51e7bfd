//! Bodies and grasps in the formats of other programs.
//!
//! | file | subject |
//! |---|---|
//! | `body.rs` | the surface that is exported, the whole or a coarser one |
//! | `glb.rs` | the container of glTF 2.0: nodes, meshes, materials, their bytes |
//! | `mesh.rs` | a mesh as GLB, STL or PLY |

mod body;
mod glb;
mod mesh;

pub use body::{Body, MAX_BUDGET, MIN_BUDGET};
pub use mesh::{MeshFormat, mesh};
