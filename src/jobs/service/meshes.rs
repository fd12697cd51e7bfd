//! Meshes: added, read, listed, deleted.

use std::sync::Arc;

use super::state::{Inner, Service};
use crate::jobs::error::Error;
use crate::jobs::ingest;
use crate::run::mesh_report;
use crate::store::{Deletion, NewMesh, Owner, Received, StoreError, Upload};
use crate::wire::{MeshId, MeshOptions, MeshPage, MeshRecord};
use graspd_mesh_io::MeshFormat;

/// A mesh file that has arrived, and what its sender says about it.
pub struct MeshUpload {
    pub upload: Upload,
    pub options: MeshOptions,
    pub file_name: Option<String>,
}

impl Service {
    /// Returns a file on disk to receive a mesh into; it is removed unless it becomes one. Refused as on a full disk when
    /// too little of it is free.
    pub async fn begin_upload(&self) -> Result<Upload, Error> {
        self.0.check_open()?;
        self.0.check_memory()?;
        self.0.check_room().await?;
        Ok(self.0.store.begin_upload().await?)
    }

    /// Reads, checks and keeps a mesh; it is on stable storage once this returns. Returns whether it is new: the same
    /// bytes in the same format, unit and scale are the same mesh, under its first name. Nothing is kept of a mesh that
    /// cannot be used.
    pub async fn add_mesh(
        &self,
        owner: &Owner,
        MeshUpload {
            upload,
            options,
            file_name,
        }: MeshUpload,
    ) -> Result<(MeshRecord, bool), Error> {
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            inner.check_open()?;
            let _slot = inner.slots.upload()?;
            let received = upload.finish().await?;
            if let Some(known) = inner.find_by_content(&owner, &received, &options).await? {
                if let Some(kept) = inner.store.mesh_summary(&owner, &known.id).await? {
                    let every = inner.limits.mark_used_every;
                    inner
                        .store
                        .mark_used(&owner, &known.id, &kept, every)
                        .await?;
                }
                return Ok((known, false));
            }
            let (received, mesh) = inner
                .ingest_mesh(&owner, received, options, file_name)
                .await?;
            let outcome = inner.store.add_mesh(received, &mesh).await?;
            outcome.map_err(|refusal| inner.refused(&owner, refusal))
        })
        .await
    }

    /// Returns the record of a mesh.
    pub async fn mesh(&self, owner: &Owner, id: &str) -> Result<MeshRecord, Error> {
        let id = MeshId::parse(id).ok_or(Error::NotFound)?;
        self.0.store.mesh(owner, &id).await?.ok_or(Error::NotFound)
    }

    /// Returns at most `limit` meshes (1 to [`crate::store::MAX_PAGE`]), newest first, from where the page that returned
    /// `cursor` ended.
    pub async fn meshes(
        &self,
        owner: &Owner,
        limit: u32,
        cursor: Option<&str>,
    ) -> Result<MeshPage, Error> {
        let page = self.0.store.meshes(owner, cursor, limit).await?;
        page.ok_or(Error::InvalidCursor)
    }

    /// Deletes a mesh unless a queued or running job needs it.
    pub async fn delete_mesh(&self, owner: &Owner, id: &str) -> Result<(), Error> {
        let id = MeshId::parse(id).ok_or(Error::NotFound)?;
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let store = &inner.store;
            match store.delete_mesh(&owner, &id).await? {
                Deletion::Done => {
                    inner.context.meshes.remove(&id);
                    Ok(())
                }
                Deletion::NotFound => Err(Error::NotFound),
                Deletion::InUse => Err(Error::MeshInUse),
            }
        })
        .await
    }
}

impl Inner {
    /// Returns the mesh that these bytes already are. One whose file was lost is not found: adding the bytes again mends
    /// it under the record that it has.
    pub(super) async fn find_by_content(
        &self,
        owner: &Owner,
        received: &Received,
        options: &MeshOptions,
    ) -> Result<Option<MeshRecord>, StoreError> {
        let &MeshOptions {
            format,
            units,
            scale,
        } = options;
        for candidate in MeshFormat::ALL {
            let id = received.mesh_id(candidate, units, scale);
            if format.is_none_or(|format| format == candidate)
                && let Some(mesh) = self.store.mesh(owner, &id).await?
                && self.store.has_mesh_file(&mesh.id).await?
            {
                return Ok(Some(mesh));
            }
        }
        Ok(None)
    }

    /// Reads and prepares a received mesh, a few at a time.
    pub(super) async fn ingest_mesh(
        &self,
        owner: &Owner,
        mut received: Received,
        options: MeshOptions,
        file_name: Option<String>,
    ) -> Result<(Received, NewMesh), Error> {
        // The store decides in the end; this only spares the work of reading a mesh for nothing.
        if let Some(room) = self.quota(owner).mesh_bytes
            && self
                .store
                .mesh_bytes(owner)
                .await?
                .saturating_add(received.bytes)
                > room
        {
            return Err(Error::MeshQuotaUsed { room });
        }
        let permit = self.slots.ingest().await?;
        let limits = self.context.limits;
        let work = move || -> Result<_, Error> {
            let _permit = permit;
            let bytes = received.read().map_err(StoreError::from)?;
            let prepared = ingest::prepare_mesh(bytes, &options, &limits);
            Ok((received, prepared.map_err(Error::Refused)?))
        };
        let (received, (format, mesh)) = tokio::task::spawn_blocking(work)
            .await
            .map_err(Error::bug)??;
        let MeshOptions { units, scale, .. } = options;
        let report = mesh_report(&mesh, units);
        let id = received.mesh_id(format, units, scale);
        self.context.meshes.put(id, Arc::new(mesh));
        let mesh = NewMesh {
            owner: owner.clone(),
            format,
            units,
            scale,
            file_name,
            report,
            max_owner_bytes: self.quota(owner).mesh_bytes,
        };
        Ok((received, mesh))
    }
}
