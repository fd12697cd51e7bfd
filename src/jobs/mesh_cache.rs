//! A few prepared meshes in memory, so that jobs on the same mesh do not read it again.

use std::sync::{Arc, Mutex, PoisonError};

use crate::wire::MeshId;
use graspd_core::mesh::Mesh;

/// Most triangles of all meshes in the cache together; at about 50 bytes each, 100 MB.
const MAX_TRIANGLES: usize = 2_000_000;

/// The meshes used last, as many as fit.
#[derive(Debug, Default)]
pub struct MeshCache {
    /// The one used last comes last.
    meshes: Mutex<Vec<(MeshId, Arc<Mesh>)>>,
}

impl MeshCache {
    pub fn get(&self, id: &MeshId) -> Option<Arc<Mesh>> {
        let mut meshes = self.lock();
        let found = meshes.iter().position(|(known, _)| known == id)?;
        let entry = meshes.remove(found);
        let mesh = Arc::clone(&entry.1);
        meshes.push(entry);
        Some(mesh)
    }

    /// Keeps `mesh` and drops those unused for longest to make room. A mesh that alone is too
    /// big is not kept.
    pub fn put(&self, id: MeshId, mesh: Arc<Mesh>) {
        let size = |mesh: &Mesh| mesh.triangles().len();
        let mut room = MAX_TRIANGLES;
        let mut meshes = self.lock();
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

    pub fn forget(&self, id: &MeshId) {
        self.lock().retain(|(known, _)| known != id);
    }

    /// Drops all of them, but for those in use.
    pub fn clear(&self) {
        self.lock().clear();
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<(MeshId, Arc<Mesh>)>> {
        self.meshes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
