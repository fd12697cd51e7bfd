//! The state that workers, watchdog and service share.

use std::sync::Arc;

use serde_json::value::RawValue;

use super::ingest::IngestLimits;
use super::lifecycle::Lifecycle;
use super::memory::Memory;
use super::mesh_cache::MeshCache;
use super::queue::Queue;
use super::running::Running;
use crate::cluster::Changes;
use crate::metrics::Metrics;
use crate::store::SharedStore;
use crate::wire::{PlanRequest, Problem, Progress};
use graspd_core::Interrupt;
use graspd_core::mesh::Mesh;

/// Plans a job: takes the mesh, the settings, an interrupt, and a function that receives the progress.
/// Returns the result as JSON; if it was interrupted, what was found so far.
pub type Runner = dyn Fn(
        &Mesh,
        &PlanRequest,
        Interrupt<'_>,
        &mut (dyn FnMut(&Progress) + Send),
    ) -> Result<Box<RawValue>, Problem>
    + Send
    + Sync;

/// The state that exists once per process.
pub struct Context {
    pub store: SharedStore,
    pub changes: Arc<Changes>,
    pub queue: Arc<Queue>,
    /// The jobs that run here.
    pub running: Arc<Running>,
    pub lifecycle: Lifecycle,
    pub metrics: Metrics,
    pub memory: Memory,
    /// The meshes in memory.
    pub meshes: MeshCache,
    /// Limits on reading a mesh.
    pub limits: IngestLimits,
    pub runner: Arc<Runner>,
}
