//! Prepared meshes in memory, so that jobs on the same mesh do not read it again.

use std::sync::Arc;

use parking_lot::Mutex;

use crate::wire::MeshId;
use graspd_core::mesh::Mesh;

/// Most triangles of all cached meshes together: at about 50 bytes each, 100 MB.
const MAX_TRIANGLES: usize = 2_000_000;

/// The most recently used meshes, as many as fit.
#[derive(Debug, Default)]
pub struct MeshCache {
    /// In the order of their last use, the most recent last.
    meshes: Mutex<Vec<(MeshId, Arc<Mesh>)>>,
}

impl MeshCache {
    /// Returns a mesh and marks it as used.
    pub fn get(&self, id: &MeshId) -> Option<Arc<Mesh>> {
        let mut meshes = self.meshes.lock();
        let found = meshes.iter().position(|(known, _)| known == id)?;
        let entry = meshes.remove(found);
        let mesh = Arc::clone(&entry.1);
        meshes.push(entry);
        Some(mesh)
    }

    /// Keeps a mesh and drops those unused for longest to make room. One that is too large by itself is not kept.
    pub fn put(&self, id: MeshId, mesh: Arc<Mesh>) {
        let size = |mesh: &Mesh| mesh.triangles().len();
        let mut room = MAX_TRIANGLES;
        let mut meshes = self.meshes.lock();
        meshes.retain(|(known, _)| *known != id);
        meshes.push((id, mesh));
        let fitting = meshes.iter().rev().take_while(|(_, mesh)| {
            let left = room.checked_sub(size(mesh));
            room = left.unwrap_or(0);
            left.is_some()
        });
        let surplus = meshes.len() - fitting.count();
        meshes.drain(..surplus);
    }

    /// Drops a mesh, as it was deleted.
    pub fn remove(&self, id: &MeshId) {
        self.meshes.lock().retain(|(known, _)| known != id);
    }

    /// Drops all meshes; those in use live until they are not.
    pub fn clear(&self) {
        self.meshes.lock().clear();
    }
}
