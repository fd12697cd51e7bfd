//! Pictures and other files made from meshes.

use super::state::Service;
use crate::jobs::error::Error;
use crate::store::Owner;
use crate::wire::MeshId;
use graspd_core::mesh::Mesh;

/// A picture of more pixels, or of more triangles, is large: it takes half a second and a hundred megabytes.
const LARGE_PIXELS: u64 = 1 << 21;
const LARGE_TRIANGLES: usize = 1 << 18;

impl Service {
    /// Returns what `draw` makes of a mesh in the store: a picture of so many `pixels`, or a file of none. It runs on a
    /// thread that may block, a few at a time; large ones one after the other, refused when too many wait.
    pub async fn draw<T: Send + 'static>(
        &self,
        owner: &Owner,
        mesh_id: &str,
        pixels: u64,
        draw: impl FnOnce(&Mesh) -> T + Send + 'static,
    ) -> Result<T, Error> {
        let mesh_id = MeshId::parse(mesh_id).ok_or(Error::NotFound)?;
        self.0.check_memory()?;
        let mesh = match self.0.prepared_mesh(owner, &mesh_id).await {
            Err(Error::UnknownMesh) => return Err(Error::NotFound),
            found => found?,
        };
        let is_large = pixels > LARGE_PIXELS || mesh.triangles().len() > LARGE_TRIANGLES;
        self.run_drawing(is_large, move || draw(&mesh)).await
    }

    /// Returns what `draw` makes without a mesh, as [`Service::draw`] does.
    pub async fn draw_without_mesh<T: Send + 'static>(
        &self,
        pixels: u64,
        draw: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Error> {
        self.run_drawing(pixels > LARGE_PIXELS, draw).await
    }

    async fn run_drawing<T: Send + 'static>(
        &self,
        is_large: bool,
        draw: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Error> {
        let slots = &self.0.slots;
        let large = match is_large {
            true => Some(slots.large_picture().await?),
            false => None,
        };
        // The wait for a turn may have been long.
        self.0.check_memory()?;
        let permits = slots.picture(large).await?;
        let work = move || {
            let _permits = permits;
            draw()
        };
        tokio::task::spawn_blocking(work).await.map_err(Error::bug)
    }
}
