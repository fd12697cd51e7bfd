//! Meshes: a row and a file each, which come and go together.

use std::time::Duration;

use async_trait::async_trait;
use sqlx::sqlite::SqliteRow;
use sqlx::{FromRow, Row};

use super::{Sqlite, Statement, blocking, jobs, now};
use crate::store::rows::{KeptRow, MeshRow, mesh_columns};
use crate::store::{
    Deletion, Kept, MAX_PAGE, Meshes, NewJob, NewMesh, Owner, Received, Refusal, StoreError,
    Upload, cursor, damaged,
};
use crate::wire::{JobRecord, MeshId, MeshOptions, MeshPage, MeshRecord, Units};

/// Writes the row of mesh `id`; one that is there was used just now.
fn insert<'m>(mesh: &'m NewMesh, id: &MeshId, bytes: u64) -> Result<Statement<'m>, StoreError> {
    Ok(sqlx::query(
        "INSERT INTO meshes \
         (id, format, bytes, candidates, file_name, created_at, used_at, report, units, scale, owner) \
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?6, ?7, ?8, ?9, ?10) \
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

#[async_trait]
impl Meshes for Sqlite {
    async fn begin_upload(&self) -> Result<Upload, StoreError> {
        let (files, received) = (self.files.clone(), self.metrics.upload_bytes.clone());
        blocking(move || files.begin_upload(received)).await
    }

    async fn mesh(&self, owner: &Owner, id: &MeshId) -> Result<Option<MeshRecord>, StoreError> {
        let row: Option<MeshRow> = sqlx::query_as(concat!(
            "SELECT ",
            mesh_columns!(),
            " FROM meshes WHERE owner = ?1 AND id = ?2"
        ))
        .bind(owner.as_str())
        .bind(id.as_str())
        .fetch_optional(&self.readers)
        .await?;
        row.map(TryInto::try_into).transpose()
    }

    async fn kept(&self, owner: &Owner, id: &MeshId) -> Result<Option<Kept>, StoreError> {
        let row: Option<KeptRow> = sqlx::query_as(
            "SELECT candidates, units, used_at FROM meshes WHERE owner = ?1 AND id = ?2",
        )
        .bind(owner.as_str())
        .bind(id.as_str())
        .fetch_optional(&self.readers)
        .await?;
        row.map(TryInto::try_into).transpose()
    }

    async fn touch(
        &self,
        owner: &Owner,
        id: &MeshId,
        kept: &Kept,
        every: Duration,
    ) -> Result<(), StoreError> {
        let now = now();
        if i128::from(now) - i128::from(kept.used_at) > every.as_micros() as i128 {
            sqlx::query("UPDATE meshes SET used_at = ?3 WHERE owner = ?1 AND id = ?2")
                .bind(owner.as_str())
                .bind(id.as_str())
                .bind(now)
                .execute(&self.writer)
                .await?;
        }
        Ok(())
    }

    async fn mesh_bytes(&self, owner: &Owner) -> Result<u64, StoreError> {
        let sum: i64 =
            sqlx::query_scalar("SELECT coalesce(sum(bytes), 0) FROM meshes WHERE owner = ?1")
                .bind(owner.as_str())
                .fetch_one(&self.readers)
                .await?;
        Ok(sum as u64)
    }

    async fn meshes(
        &self,
        owner: &Owner,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<MeshPage>, StoreError> {
        const LIST: &str = "meshes";
        let before = match cursor {
            None => i64::MAX,
            Some(cursor) => match cursor::decode(LIST, cursor).map(str::parse) {
                Some(Ok(seq)) => seq,
                _ => return Ok(None),
            },
        };
        let limit = limit.clamp(1, MAX_PAGE) as usize;
        let rows = sqlx::query(concat!(
            "SELECT seq, ",
            mesh_columns!(),
            " FROM meshes WHERE seq < ?1 AND owner = ?3 ORDER BY seq DESC LIMIT ?2"
        ))
        .bind(before)
        .bind(limit as i64 + 1)
        .bind(owner.as_str())
        .fetch_all(&self.readers)
        .await?;
        let record =
            |row: &SqliteRow| Ok((row.try_get("seq")?, MeshRow::from_row(row)?.try_into()?));
        let meshes: Vec<(i64, MeshRecord)> =
            rows.iter().map(record).collect::<Result<_, StoreError>>()?;
        let (meshes, next_cursor) = cursor::page(LIST, meshes, limit, |(seq, _)| seq.to_string());
        let meshes = meshes.into_iter().map(|(_, mesh)| mesh).collect();
        Ok(Some(MeshPage {
            meshes,
            next_cursor,
        }))
    }

    async fn has_mesh_file(&self, id: &MeshId) -> Result<bool, StoreError> {
        Ok(tokio::fs::try_exists(self.files.path(id)).await?)
    }

    async fn mesh_file(
        &self,
        owner: &Owner,
        id: &MeshId,
    ) -> Result<Option<(MeshOptions, Vec<u8>)>, StoreError> {
        let Some(mesh) = self.mesh(owner, id).await? else {
            return Ok(None);
        };
        match tokio::fs::read(self.files.path(id)).await {
            Ok(bytes) => Ok(Some((mesh.options(), bytes))),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    async fn add_mesh(
        &self,
        received: Received,
        mesh: &NewMesh,
    ) -> Result<Result<(MeshRecord, bool), Refusal>, StoreError> {
        let _guard = self.mesh_change.lock().await;
        let id = received.mesh_id(mesh.format, mesh.units, mesh.scale);
        let outcome = self.publish_and_insert(received, mesh, &id).await;
        if !matches!(outcome, Ok(Ok(_))) {
            self.unpublish(&id).await;
        }
        outcome
    }

    async fn add_mesh_and_job(
        &self,
        received: Received,
        mesh: &NewMesh,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        let _guard = self.mesh_change.lock().await;
        let id = received.mesh_id(mesh.format, mesh.units, mesh.scale);
        let outcome = self.publish_and_insert_with(received, mesh, job, &id).await;
        if !matches!(outcome, Ok(Ok(_))) {
            self.unpublish(&id).await;
        }
        outcome
    }

    async fn delete_mesh(&self, owner: &Owner, id: &MeshId) -> Result<Deletion, StoreError> {
        let _guard = self.mesh_change.lock().await;
        let delete = || async {
            let deleted = sqlx::query(
                "DELETE FROM meshes WHERE owner = ?1 AND id = ?2 AND NOT EXISTS (SELECT 1 FROM jobs \
                 WHERE owner = ?1 AND mesh_id = ?2 AND state IN ('queued', 'running'))",
            )
            .bind(owner.as_str())
            .bind(id.as_str())
            .execute(&self.writer)
            .await?;
            Ok(deleted.rows_affected() > 0)
        };
        if !self.with_reserve(delete).await? {
            return Ok(match self.kept(owner, id).await? {
                Some(_) => Deletion::InUse,
                None => Deletion::NotFound,
            });
        }
        // The mesh is forgotten whatever becomes of its file, which the next start removes.
        if let Err(error) = self.drop_unowned_file(id).await {
            tracing::warn!(mesh = %id, %error, "a file without a record stays until restart");
        }
        Ok(Deletion::Done)
    }
}

impl Sqlite {
    /// Whether any owner has this mesh.
    pub(super) async fn is_anyones(&self, id: &MeshId) -> Result<bool, StoreError> {
        // Asked of the writer, which alone is sure to see what was written just now.
        Ok(
            sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM meshes WHERE id = ?1)")
                .bind(id.as_str())
                .fetch_one(&self.writer)
                .await?,
        )
    }

    async fn publish_and_insert(
        &self,
        received: Received,
        mesh: &NewMesh,
        id: &MeshId,
    ) -> Result<Result<(MeshRecord, bool), Refusal>, StoreError> {
        let bytes = received.bytes;
        let known = self.kept(&mesh.owner, id).await?.is_some();
        if !known && !self.has_room(mesh, bytes).await? {
            return Ok(Err(Refusal::RoomUsed));
        }
        self.publish(received, id).await?;
        insert(mesh, id, bytes)?.execute(&self.writer).await?;
        let record = self.mesh(&mesh.owner, id).await?;
        let record = record.ok_or_else(|| damaged("a mesh just written is gone"))?;
        Ok(Ok((record, !known)))
    }

    async fn publish_and_insert_with(
        &self,
        received: Received,
        mesh: &NewMesh,
        job: &NewJob,
        id: &MeshId,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        let bytes = received.bytes;
        if self.kept(&mesh.owner, id).await?.is_none() && !self.has_room(mesh, bytes).await? {
            return Ok(Err(Refusal::RoomUsed));
        }
        self.publish(received, id).await?;
        let mut transaction = self.writer.begin().await?;
        insert(mesh, id, bytes)?.execute(&mut *transaction).await?;
        let outcome = jobs::insert(job, id, &mut transaction).await?;
        match outcome {
            Ok(_) => transaction.commit().await?,
            Err(_) => transaction.rollback().await?,
        }
        Ok(outcome)
    }

    /// Whether so many bytes more may be their owner's.
    async fn has_room(&self, mesh: &NewMesh, bytes: u64) -> Result<bool, StoreError> {
        Ok(match mesh.room {
            None => true,
            Some(room) => self.mesh_bytes(&mesh.owner).await?.saturating_add(bytes) <= room,
        })
    }

    async fn publish(&self, received: Received, id: &MeshId) -> Result<(), StoreError> {
        let (files, id) = (self.files.clone(), id.clone());
        let unnamed = || std::io::Error::other("what was received has no name");
        blocking(move || files.publish(received.path.ok_or_else(unnamed)?, &id)).await
    }

    /// Takes back a file whose row was not written, unless an earlier upload wrote it.
    async fn unpublish(&self, id: &MeshId) {
        // In doubt the file stays: one too many is swept at the next start, one too few is lost.
        if let Err(error) = self.drop_unowned_file(id).await {
            tracing::warn!(mesh = %id, %error, "a file without a record stays until restart");
        }
    }
}
