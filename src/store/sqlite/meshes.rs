//! Meshes: a row and a file each, which come and go together.
//!
//! The file is published before its row is written and removed after the row is gone, so that a crash in between
//! leaves a file without a row, which the next start removes, and never a row without its file.

use std::time::Duration;

use async_trait::async_trait;

use super::{Sqlite, Statement, blocking, jobs, now};
use crate::store::common::meshes::{KeptMesh, MeshEngine};
use crate::store::{
    Deletion, MeshSummary, Meshes, NewJob, NewMesh, Owner, Received, Refusal, StoreError, Upload,
    damaged,
};
use crate::wire::{MeshId, MeshRecord, Units};

#[async_trait]
impl MeshEngine for Sqlite {
    async fn new_upload(&self) -> Result<Upload, StoreError> {
        let (files, received) = (self.files.clone(), self.metrics.upload_bytes.clone());
        blocking(move || files.begin_upload(received)).await
    }

    async fn note_use(
        &self,
        owner: &Owner,
        mesh: &MeshSummary,
        id: &MeshId,
        every: Duration,
    ) -> Result<(), StoreError> {
        let now = now();
        if i128::from(now) - i128::from(mesh.used_at) > every.as_micros() as i128 {
            let statement =
                sqlx::query("UPDATE meshes SET used_at = $3 WHERE owner = $1 AND id = $2")
                    .bind(owner.as_str())
                    .bind(id.as_str())
                    .bind(now);
            self.writer.run(statement).await?;
        }
        Ok(())
    }

    async fn has_file(&self, id: &MeshId) -> Result<bool, StoreError> {
        Ok(tokio::fs::try_exists(self.files.path(id)).await?)
    }

    async fn file_of(
        &self,
        _owner: &Owner,
        mesh: &MeshRecord,
    ) -> Result<Option<Vec<u8>>, StoreError> {
        match tokio::fs::read(self.files.path(&mesh.id)).await {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    async fn keep_mesh(
        &self,
        received: Received,
        mesh: &NewMesh,
        id: &MeshId,
        job: Option<&NewJob>,
    ) -> Result<Result<KeptMesh, Refusal>, StoreError> {
        let _guard = self.mesh_change.lock().await;
        let outcome = self.publish_and_insert(received, mesh, id, job).await;
        if !matches!(outcome, Ok(Ok(_))) {
            // Unless an earlier upload of the same mesh was kept.
            self.remove_unowned_file_or_leave_it(id).await;
        }
        outcome
    }

    async fn remove_mesh(&self, owner: &Owner, id: &MeshId) -> Result<Deletion, StoreError> {
        let _guard = self.mesh_change.lock().await;
        let delete = || async {
            let statement = sqlx::query(
                "DELETE FROM meshes WHERE owner = $1 AND id = $2 AND NOT EXISTS (SELECT 1 FROM jobs \
                 WHERE owner = $1 AND mesh_id = $2 AND state IN ('queued', 'running'))",
            )
            .bind(owner.as_str())
            .bind(id.as_str());
            Ok(self.writer.run(statement).await?.changed())
        };
        if self.with_reserve(delete).await? == 0 {
            return Ok(match self.mesh_summary(owner, id).await? {
                Some(_) => Deletion::InUse,
                None => Deletion::NotFound,
            });
        }
        self.remove_unowned_file_or_leave_it(id).await;
        Ok(Deletion::Done)
    }
}

impl Sqlite {
    async fn publish_and_insert(
        &self,
        received: Received,
        mesh: &NewMesh,
        id: &MeshId,
        job: Option<&NewJob>,
    ) -> Result<Result<KeptMesh, Refusal>, StoreError> {
        let bytes = received.bytes;
        let is_new = self.mesh_summary(&mesh.owner, id).await?.is_none();
        if is_new && !mesh.fits(self.mesh_bytes(&mesh.owner).await?, bytes) {
            return Ok(Err(Refusal::OwnerStorageFull));
        }
        self.publish(received, id).await?;
        let mut transaction = self.writer.begin().await?;
        transaction.run(insert(mesh, id, bytes)?).await?;
        let job = match job {
            None => None,
            Some(job) => match jobs::insert(job, id, &mut transaction).await? {
                Ok(job) => Some(job),
                Err(refusal) => {
                    transaction.end(false).await?;
                    return Ok(Err(refusal));
                }
            },
        };
        transaction.end(true).await?;
        Ok(Ok(KeptMesh { is_new, job }))
    }

    async fn publish(&self, received: Received, id: &MeshId) -> Result<(), StoreError> {
        let (files, id) = (self.files.clone(), id.clone());
        let unnamed = || std::io::Error::other("what was received has no name");
        blocking(move || files.publish(received.path.ok_or_else(unnamed)?, &id)).await
    }

    /// Removes the file of a mesh that no owner has any more. The caller holds `mesh_change`.
    pub(super) async fn remove_unowned_file(&self, id: &MeshId) -> Result<(), StoreError> {
        // The writer is asked, which alone is sure to see what was written just now.
        let statement = sqlx::query("SELECT EXISTS (SELECT 1 FROM meshes WHERE id = $1)");
        let answer = self.writer.read(statement.bind(id.as_str())).await?;
        let (is_owned,) = answer.one::<(bool,)>()?;
        if !is_owned {
            let (files, id) = (self.files.clone(), id.clone());
            blocking(move || files.remove(&id)).await?;
        }
        Ok(())
    }

    /// The same; in doubt the file stays, since the next start removes one too many, but nobody brings back one too
    /// few.
    async fn remove_unowned_file_or_leave_it(&self, id: &MeshId) {
        if let Err(error) = self.remove_unowned_file(id).await {
            tracing::warn!(mesh = %id, %error, "a file without a record stays until restart");
        }
    }
}

/// Writes the row of mesh `id`; one that is there was used just now.
fn insert<'m>(mesh: &'m NewMesh, id: &MeshId, bytes: u64) -> Result<Statement<'m>, StoreError> {
    Ok(sqlx::query(
        "INSERT INTO meshes \
         (id, format, bytes, candidates, file_name, created_at, used_at, report, units, scale, owner) \
         VALUES ($1, $2, $3, $4, $5, $6, $6, $7, $8, $9, $10) \
         ON CONFLICT (owner, id) DO UPDATE SET used_at = excluded.used_at",
    )
    .bind(id.to_string())
    .bind(mesh.format.name())
    .bind(bytes as i64)
    .bind(mesh.report.candidates as i64)
    .bind(mesh.file_name.as_deref())
    .bind(now())
    .bind(serde_json::to_string(&mesh.report).map_err(damaged)?)
    .bind(mesh.units.map(Units::name))
    .bind(mesh.scale)
    .bind(mesh.owner.as_str()))
}
