//! Meshes and grasps that are drawn.

use std::sync::Arc;

use super::{Service, bug};
use crate::jobs::error::Error;
use crate::store::Owner;
use crate::wire::MeshId;
use graspd_core::mesh::Mesh;

/// Pixels, and triangles, beyond which a picture is a heavy one: half a second, a hundred megabytes.
const HEAVY_PIXELS: u64 = 1 << 21;
const HEAVY_TRIANGLES: usize = 1 << 18;

impl Service {
    /// What `draw` makes of a mesh that is here, on a thread that may block, a few at a time; `pixels` of it, where it
    /// is a picture. Heavy ones are made one after the other, so that there is always a place for the others, and
    /// refused when too many wait.
    pub async fn draw<T: Send + 'static>(
        &self,
        owner: &Owner,
        mesh_id: &str,
        pixels: u64,
        draw: impl FnOnce(&Mesh) -> T + Send + 'static,
    ) -> Result<T, Error> {
        let mesh_id = MeshId::parse(mesh_id).ok_or(Error::NotFound)?;
        self.0.check_memory()?;
        let mesh = match self.0.prepared(owner, &mesh_id).await {
            Err(Error::UnknownMesh) => return Err(Error::NotFound),
            found => found?,
        };
        let is_heavy = pixels > HEAVY_PIXELS || mesh.triangles().len() > HEAVY_TRIANGLES;
        self.make(is_heavy, move || draw(&mesh)).await
    }

    /// What `draw` makes without a mesh, likewise.
    pub async fn draw_without_mesh<T: Send + 'static>(
        &self,
        pixels: u64,
        draw: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Error> {
        self.make(pixels > HEAVY_PIXELS, draw).await
    }

    async fn make<T: Send + 'static>(
        &self,
        is_heavy: bool,
        draw: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Error> {
        let heavy = match is_heavy {
            false => None,
            true => {
                let line = Arc::clone(&self.0.heavy_line).try_acquire_owned();
                let line = line.map_err(|_| Error::Unready {
                    kind: "busy",
                    detail: "as many large pictures wait to be drawn as may; ask again in a moment, or for a smaller one",
                })?;
                let turn = Arc::clone(&self.0.heavy).acquire_owned().await;
                Some((line, turn.map_err(bug)?))
            }
        };
        self.0.check_memory()?;
        // Drawing goes on when the caller is gone, and has to count until it ends.
        let permit = Arc::clone(&self.0.pictures).acquire_owned().await;
        let permit = permit.map_err(bug)?;
        let work = move || {
            let _places = (heavy, permit);
            draw()
        };
        tokio::task::spawn_blocking(work).await.map_err(bug)
    }
}
