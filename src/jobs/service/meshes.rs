//! Meshes: taken in, read, listed, forgotten.

use std::sync::Arc;

use super::{Inner, MeshUpload, Service, bug};
use crate::jobs::error::Error;
use crate::jobs::ingest;
use crate::run::mesh_report;
use crate::store::{Deletion, NewMesh, Owner, Received, StoreError, Upload};
use crate::wire::{MeshId, MeshOptions, MeshPage, MeshRecord};
use graspd_mesh_io::MeshFormat;

impl Service {
    /// A file on disk to receive a mesh into; it is removed unless it becomes one. Refused as on a
    /// full disk when too little of it is free.
    pub async fn begin_upload(&self) -> Result<Upload, Error> {
        self.0.check_open()?;
        self.0.check_memory()?;
        self.0.check_room().await?;
        Ok(self.0.store.begin_upload().await?)
    }

    /// Reads, checks and keeps a mesh; it is on stable storage once this returns. Says whether
    /// it is new: the same bytes in the same format, unit and scale are the same mesh, under its first
    /// name. Of a mesh that cannot be used nothing stays.
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
            let _place = inner.wait_in_line()?;
            let received = upload.finish().await?;
            if let Some(known) = inner.find_by_content(&owner, &received, &options).await? {
                if let Some(kept) = inner.store.kept(&owner, &known.id).await? {
                    let every = inner.touch_every;
                    inner.store.touch(&owner, &known.id, &kept, every).await?;
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

    /// The record of a mesh.
    pub async fn mesh(&self, owner: &Owner, id: &str) -> Result<MeshRecord, Error> {
        let id = MeshId::parse(id).ok_or(Error::NotFound)?;
        self.0.store.mesh(owner, &id).await?.ok_or(Error::NotFound)
    }

    /// At most `limit` meshes (1 to [`crate::store::MAX_PAGE`]), newest first, from where the
    /// page that answered `cursor` ended.
    pub async fn meshes(
        &self,
        owner: &Owner,
        limit: u32,
        cursor: Option<&str>,
    ) -> Result<MeshPage, Error> {
        let page = self.0.store.meshes(owner, cursor, limit).await?;
        page.ok_or(Error::InvalidCursor)
    }

    /// Forgets a mesh unless a queued or running job needs it.
    pub async fn delete_mesh(&self, owner: &Owner, id: &str) -> Result<(), Error> {
        let id = MeshId::parse(id).ok_or(Error::NotFound)?;
        let owner = owner.clone();
        self.run_detached(move |inner| async move {
            let store = &inner.store;
            match store.delete_mesh(&owner, &id).await? {
                Deletion::Done => {
                    inner.shared.meshes.forget(&id);
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
    /// The mesh that these bytes already are. One whose file was lost is not known: taking the
    /// bytes in again mends it under the row that it has.
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
        // The store decides; this only spares the work of a hopeless intake.
        if let Some(room) = self.quota.of(owner).mesh_bytes
            && self
                .store
                .mesh_bytes(owner)
                .await?
                .saturating_add(received.bytes)
                > room
        {
            return Err(Error::MeshQuotaUsed { room });
        }
        let permit = self.intake().await?;
        let limits = self.shared.limits;
        let work = move || -> Result<_, Error> {
            let _permit = permit;
            let bytes = received.read().map_err(StoreError::from)?;
            let prepared = ingest::prepare_mesh(bytes, &options, &limits);
            Ok((received, prepared.map_err(Error::Refused)?))
        };
        let (received, (format, mesh)) = tokio::task::spawn_blocking(work).await.map_err(bug)??;
        let MeshOptions { units, scale, .. } = options;
        let report = mesh_report(&mesh, units);
        let id = received.mesh_id(format, units, scale);
        self.shared.meshes.put(id, Arc::new(mesh));
        let mesh = NewMesh {
            owner: owner.clone(),
            format,
            units,
            scale,
            file_name,
            report,
            room: self.quota.of(owner).mesh_bytes,
        };
        Ok((received, mesh))
    }
}
