//! Meshes and grasps that are drawn.

use std::sync::Arc;

use super::{Service, bug};
use crate::core::mesh::Mesh;
use crate::jobs::error::Error;
use crate::store::Owner;
use crate::wire::MeshId;

impl Service {
    /// What `draw` makes of a mesh that is here, on a thread that may block, a few at a time.
    pub async fn draw<T: Send + 'static>(
        &self,
        owner: &Owner,
        mesh_id: &str,
        draw: impl FnOnce(&Mesh) -> T + Send + 'static,
    ) -> Result<T, Error> {
        let mesh_id = MeshId::parse(mesh_id).ok_or(Error::NotFound)?;
        let mesh = match self.0.prepared(owner, &mesh_id).await {
            Err(Error::UnknownMesh) => return Err(Error::NotFound),
            found => found?,
        };
        self.picture(move || draw(&mesh)).await
    }

    /// What `draw` makes, on a thread that may block, a few at a time.
    pub async fn picture<T: Send + 'static>(
        &self,
        draw: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Error> {
        // Drawing goes on when the caller is gone, and has to count until it ends.
        let permit = Arc::clone(&self.0.pictures).acquire_owned().await;
        let permit = permit.map_err(bug)?;
        let work = move || {
            let _permit = permit;
            draw()
        };
        tokio::task::spawn_blocking(work).await.map_err(bug)
    }
}
