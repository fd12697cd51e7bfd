//! Meshes: a row and a file each, which come and go together.

use std::time::Duration;

use serde_json::value::RawValue;
use sqlx::Row;
use sqlx::sqlite::SqliteRow;

use super::jobs::{NewJob, Refusal};
use super::{
    MAX_PAGE, Owner, Received, Statement, Store, StoreError, blocking, cursor, damaged, now,
    timestamp,
};
use crate::core::mesh::Format;
use crate::wire::{
    JobRecord, MeshFormat, MeshId, MeshOptions, MeshPage, MeshRecord, MeshReport, Units,
};

/// What is to be known of a mesh whose file has been received and found usable.
#[derive(Debug)]
pub struct NewMesh {
    pub owner: Owner,
    pub format: MeshFormat,
    pub units: Option<Units>,
    pub scale: f64,
    pub file_name: Option<String>,
    pub report: MeshReport,
    /// Most bytes that the files of its owner's meshes may have in all.
    pub room: Option<u64>,
}

impl NewMesh {
    /// Writes the row of mesh `id`; one that is there was used just now.
    fn insert(&self, id: &MeshId, bytes: u64) -> Result<Statement<'_>, StoreError> {
        Ok(sqlx::query(
            "INSERT INTO meshes \
             (id, format, bytes, candidates, file_name, created_at, used_at, report, units, scale, owner) \
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?6, ?7, ?8, ?9, ?10) \
             ON CONFLICT (owner, id) DO UPDATE SET used_at = excluded.used_at",
        )
        .bind(id.to_string())
        .bind(self.format.name())
        .bind(bytes as i64)
        .bind(self.report.candidates as i64)
        .bind(self.file_name.as_deref())
        .bind(now())
        .bind(serde_json::to_string(&self.report).map_err(damaged)?)
        .bind(self.units.map(Units::name))
        .bind(self.scale)
        .bind(self.owner.as_str()))
    }
}

/// What a job needs to know of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct Kept {
    /// Triangles that a finger may be put on.
    pub candidates: u64,
    pub units: Option<Units>,
    /// Microseconds since 1970.
    used_at: i64,
}

/// What came of a wish to forget a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deletion {
    Done,
    NotFound,
    /// A queued or running job needs it.
    InUse,
}

macro_rules! columns {
    () => {
        "id, format, units, scale, bytes, file_name, created_at, report"
    };
}

impl Store {
    /// The record of a mesh of an owner.
    pub async fn mesh(&self, owner: &Owner, id: &MeshId) -> Result<Option<MeshRecord>, StoreError> {
        let select = concat!(
            "SELECT ",
            columns!(),
            " FROM meshes WHERE owner = ?1 AND id = ?2"
        );
        sqlx::query(select)
            .bind(owner.as_str())
            .bind(id.as_str())
            .fetch_optional(&self.readers)
            .await?
            .map(|row| record(&row))
            .transpose()
    }

    /// What a job needs to know of a mesh, if it is here.
    pub async fn kept(&self, owner: &Owner, id: &MeshId) -> Result<Option<Kept>, StoreError> {
        let row = sqlx::query(
            "SELECT candidates, units, used_at FROM meshes WHERE owner = ?1 AND id = ?2",
        )
        .bind(owner.as_str())
        .bind(id.as_str())
        .fetch_optional(&self.readers)
        .await?;
        row.map(|row| {
            Ok(Kept {
                candidates: row.try_get::<i64, _>("candidates")? as u64,
                units: units(&row)?,
                used_at: row.try_get("used_at")?,
            })
        })
        .transpose()
    }

    /// Notes that a mesh was asked for, unless that is known to within `every`.
    pub async fn touch(
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

    /// Bytes of the files of all meshes of an owner.
    pub async fn mesh_bytes(&self, owner: &Owner) -> Result<u64, StoreError> {
        let sum: i64 =
            sqlx::query_scalar("SELECT coalesce(sum(bytes), 0) FROM meshes WHERE owner = ?1")
                .bind(owner.as_str())
                .fetch_one(&self.readers)
                .await?;
        Ok(sum as u64)
    }

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

    /// At most `limit` meshes of an owner, newest first, from where `cursor` ended. `None` when the cursor
    /// is not one of this list.
    pub async fn meshes(
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
        let mut rows = sqlx::query(concat!(
            "SELECT seq, ",
            columns!(),
            " FROM meshes WHERE seq < ?1 AND owner = ?3 ORDER BY seq DESC LIMIT ?2"
        ))
        .bind(before)
        .bind(limit as i64 + 1)
        .bind(owner.as_str())
        .fetch_all(&self.readers)
        .await?;
        let more = rows.len() > limit;
        rows.truncate(limit);
        let next_cursor = match rows.last() {
            Some(last) if more => Some(cursor::encode(
                LIST,
                &last.try_get::<i64, _>("seq")?.to_string(),
            )),
            _ => None,
        };
        let meshes = rows.iter().map(record).collect::<Result<_, _>>()?;
        Ok(Some(MeshPage {
            meshes,
            next_cursor,
        }))
    }

    /// Whether the file of a mesh is on disk, as it is unless someone removed it.
    pub async fn has_mesh_file(&self, id: &MeshId) -> Result<bool, StoreError> {
        Ok(tokio::fs::try_exists(self.files.path(id)).await?)
    }

    /// How a mesh is to be read, and the bytes of its file, whole; `None` when the mesh was forgotten.
    pub async fn mesh_file(
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

    /// Keeps a mesh; it is on stable storage once this returns. Says whether it is new.
    ///
    /// Must be run to its end: dropped half-way it leaves a file without a row until the next
    /// start.
    pub async fn add_mesh(
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

    /// Keeps a mesh and a job on it, both or neither; both are on stable storage once this
    /// returns. The record of the mesh may be there already.
    ///
    /// Must be run to its end, as [`Store::add_mesh`].
    pub async fn add_mesh_and_job(
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
        mesh.insert(id, bytes)?.execute(&self.writer).await?;
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
        mesh.insert(id, bytes)?.execute(&mut *transaction).await?;
        let outcome = job.insert(id, &mut transaction).await?;
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

    /// Forgets a mesh unless a job that has not ended needs it. Must be run to its end.
    pub async fn delete_mesh(&self, owner: &Owner, id: &MeshId) -> Result<Deletion, StoreError> {
        let _guard = self.mesh_change.lock().await;
        let deleted = sqlx::query(
            "DELETE FROM meshes WHERE owner = ?1 AND id = ?2 AND NOT EXISTS (SELECT 1 FROM jobs \
             WHERE owner = ?1 AND mesh_id = ?2 AND state IN ('queued', 'running'))",
        )
        .bind(owner.as_str())
        .bind(id.as_str())
        .execute(&self.writer)
        .await?;
        if deleted.rows_affected() == 0 {
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

    async fn publish(&self, received: Received, id: &MeshId) -> Result<(), StoreError> {
        let (files, id) = (self.files.clone(), id.clone());
        blocking(move || files.publish(received.path, &id)).await
    }

    /// Takes back a file whose row was not written, unless an earlier upload wrote it.
    async fn unpublish(&self, id: &MeshId) {
        // In doubt the file stays: one too many is swept at the next start, one too few is lost.
        if let Err(error) = self.drop_unowned_file(id).await {
            tracing::warn!(mesh = %id, %error, "a file without a record stays until restart");
        }
    }
}

fn record(row: &SqliteRow) -> Result<MeshRecord, StoreError> {
    let (id, format): (&str, &str) = (row.try_get("id")?, row.try_get("format")?);
    Ok(MeshRecord {
        id: MeshId::parse(id).ok_or_else(|| damaged("mesh id"))?,
        format: Format::from_name(format)
            .ok_or_else(|| damaged("mesh format"))?
            .into(),
        units: units(row)?,
        scale: row.try_get("scale")?,
        bytes: row.try_get::<i64, _>("bytes")? as u64,
        file_name: row.try_get("file_name")?,
        created_at: timestamp(row.try_get("created_at")?)?,
        report: RawValue::from_string(row.try_get("report")?).map_err(damaged)?,
    })
}

pub(super) fn units(row: &SqliteRow) -> Result<Option<Units>, StoreError> {
    let name: Option<&str> = row.try_get("units")?;
    let named = |name| Units::named(name).ok_or_else(|| damaged("mesh units"));
    name.map(named).transpose()
}
