//! Meshes: taken in, read, listed, forgotten.

use std::time::Duration;

use async_trait::async_trait;

use super::rows::{MeshRow, MeshSummaryRow, mesh_columns};
use super::statement::Statement;
use super::{Engine, cursor, first, one};
use crate::store::{
    Deletion, MeshSummary, Meshes, NewJob, NewMesh, Owner, Received, Refusal, StoreError, Upload,
    damaged,
};
use crate::wire::{JobRecord, MeshId, MeshOptions, MeshPage, MeshRecord};

/// What the engines do with meshes each in their own way: where the file of a mesh is, and how it comes and goes
/// together with its row.
#[async_trait]
pub trait MeshEngine: Engine {
    /// An empty file to receive a mesh into.
    async fn new_upload(&self) -> Result<Upload, StoreError>;

    /// Notes that a mesh was asked for, unless that is known to within `every`.
    async fn note_use(
        &self,
        owner: &Owner,
        mesh: &MeshSummary,
        id: &MeshId,
        every: Duration,
    ) -> Result<(), StoreError>;

    /// Whether the file of a mesh is there.
    async fn has_file(&self, id: &MeshId) -> Result<bool, StoreError>;

    /// The bytes of the file of a mesh; `None` when it was forgotten.
    async fn file_of(
        &self,
        owner: &Owner,
        mesh: &MeshRecord,
    ) -> Result<Option<Vec<u8>>, StoreError>;

    /// Keeps the file and the row of mesh `id`, and a job on it where one is given: all or nothing.
    async fn keep_mesh(
        &self,
        received: Received,
        mesh: &NewMesh,
        id: &MeshId,
        job: Option<&NewJob>,
    ) -> Result<Result<KeptMesh, Refusal>, StoreError>;

    /// Forgets a mesh unless a job that has not ended needs it.
    async fn remove_mesh(&self, owner: &Owner, id: &MeshId) -> Result<Deletion, StoreError>;
}

/// The outcome of storing a mesh.
pub struct KeptMesh {
    /// Whether its owner did not have it before.
    pub is_new: bool,
    /// The job on it, where one was given.
    pub job: Option<JobRecord>,
}

#[async_trait]
impl<E: MeshEngine> Meshes for E {
    async fn begin_upload(&self) -> Result<Upload, StoreError> {
        self.new_upload().await
    }

    async fn mesh(&self, owner: &Owner, id: &MeshId) -> Result<Option<MeshRecord>, StoreError> {
        let statement = Statement::new(concat!(
            "SELECT ",
            mesh_columns!(),
            " FROM meshes WHERE owner = $1 AND id = $2"
        ));
        let statement = statement.bind(owner.as_str()).bind(id.as_str());
        let row: Option<MeshRow> = first(self, statement).await?;
        row.map(TryInto::try_into).transpose()
    }

    async fn mesh_summary(
        &self,
        owner: &Owner,
        id: &MeshId,
    ) -> Result<Option<MeshSummary>, StoreError> {
        let statement = Statement::new(
            "SELECT id, candidates, report, units, used_at FROM meshes WHERE owner = $1 AND id = $2",
        );
        let statement = statement.bind(owner.as_str()).bind(id.as_str());
        let row: Option<MeshSummaryRow> = first(self, statement).await?;
        row.map(TryInto::try_into).transpose()
    }

    async fn mark_used(
        &self,
        owner: &Owner,
        id: &MeshId,
        mesh: &MeshSummary,
        every: Duration,
    ) -> Result<(), StoreError> {
        self.note_use(owner, mesh, id, every).await
    }

    async fn mesh_bytes(&self, owner: &Owner) -> Result<u64, StoreError> {
        let statement = Statement::new(
            "SELECT CAST(coalesce(sum(bytes), 0) AS bigint) FROM meshes WHERE owner = $1",
        );
        let (bytes,): (i64,) = one(self, statement.bind(owner.as_str())).await?;
        Ok(bytes as u64)
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
        let limit = cursor::limit(limit);
        let statement = Statement::new(concat!(
            "SELECT ",
            mesh_columns!(),
            " FROM meshes WHERE seq < $1 AND owner = $2 ORDER BY seq DESC LIMIT $3"
        ))
        .bind(before)
        .bind(owner.as_str())
        .bind(limit.asked_for());
        let rows: Vec<MeshRow> = self.read(statement).await?;
        let (rows, next_cursor) = limit.page(LIST, rows, |row| row.seq.to_string());
        let meshes = rows.into_iter().map(TryInto::try_into);
        Ok(Some(MeshPage {
            meshes: meshes.collect::<Result<_, _>>()?,
            next_cursor,
        }))
    }

    async fn has_mesh_file(&self, id: &MeshId) -> Result<bool, StoreError> {
        self.has_file(id).await
    }

    async fn mesh_file(
        &self,
        owner: &Owner,
        id: &MeshId,
    ) -> Result<Option<(MeshOptions, Vec<u8>)>, StoreError> {
        let Some(mesh) = self.mesh(owner, id).await? else {
            return Ok(None);
        };
        let bytes = self.file_of(owner, &mesh).await?;
        Ok(bytes.map(|bytes| (mesh.options(), bytes)))
    }

    async fn add_mesh(
        &self,
        received: Received,
        mesh: &NewMesh,
    ) -> Result<Result<(MeshRecord, bool), Refusal>, StoreError> {
        let id = received.mesh_id(mesh.format, mesh.units, mesh.scale);
        let kept = match self.keep_mesh(received, mesh, &id, None).await? {
            Ok(kept) => kept,
            Err(refusal) => return Ok(Err(refusal)),
        };
        let record = self.mesh(&mesh.owner, &id).await?;
        let record = record.ok_or_else(|| damaged("a mesh just written is gone"))?;
        Ok(Ok((record, kept.is_new)))
    }

    async fn add_mesh_and_job(
        &self,
        received: Received,
        mesh: &NewMesh,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError> {
        let id = received.mesh_id(mesh.format, mesh.units, mesh.scale);
        let kept = match self.keep_mesh(received, mesh, &id, Some(job)).await? {
            Ok(kept) => kept,
            Err(refusal) => return Ok(Err(refusal)),
        };
        let job = kept
            .job
            .ok_or_else(|| damaged("a job just written is gone"))?;
        Ok(Ok(job))
    }

    async fn delete_mesh(&self, owner: &Owner, id: &MeshId) -> Result<Deletion, StoreError> {
        self.remove_mesh(owner, id).await
    }
}

impl NewMesh {
    /// Whether its owner has room for these bytes beside those of the meshes that are here.
    pub(in crate::store) fn fits(&self, used: u64, bytes: u64) -> bool {
        let most = self.max_owner_bytes;
        most.is_none_or(|most| used.saturating_add(bytes) <= most)
    }
}
