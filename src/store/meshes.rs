//! Meshes: taken in, read, listed, forgotten.

use std::time::Duration;

use async_trait::async_trait;

use super::jobs::{NewJob, Refusal};
use super::uploads::{Received, Upload};
use super::{Owner, StoreError};
use crate::wire::{JobRecord, MeshId, MeshOptions, MeshPage, MeshRecord, Units};
use graspd_core::mesh::MeshReport;
use graspd_mesh_io::MeshFormat;

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

/// What a job needs to know of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct Kept {
    /// Triangles that a finger may be put on.
    pub candidates: u64,
    pub units: Option<Units>,
    /// Microseconds since 1970.
    pub(super) used_at: i64,
}

/// What came of a wish to forget a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deletion {
    Done,
    NotFound,
    /// A queued or running job needs it.
    InUse,
}

/// The meshes of a store.
#[async_trait]
pub trait Meshes {
    /// An empty file to receive a mesh into; it is removed unless it becomes one.
    async fn begin_upload(&self) -> Result<Upload, StoreError>;

    /// The record of a mesh of an owner.
    async fn mesh(&self, owner: &Owner, id: &MeshId) -> Result<Option<MeshRecord>, StoreError>;

    /// What a job needs to know of a mesh, if it is here.
    async fn kept(&self, owner: &Owner, id: &MeshId) -> Result<Option<Kept>, StoreError>;

    /// Notes that a mesh was asked for, unless that is known to within `every`.
    async fn touch(
        &self,
        owner: &Owner,
        id: &MeshId,
        kept: &Kept,
        every: Duration,
    ) -> Result<(), StoreError>;

    /// Bytes of the files of all meshes of an owner.
    async fn mesh_bytes(&self, owner: &Owner) -> Result<u64, StoreError>;

    /// At most `limit` meshes of an owner, newest first, from where `cursor` ended. `None` when the cursor
    /// is not one of this list.
    async fn meshes(
        &self,
        owner: &Owner,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<MeshPage>, StoreError>;

    /// Whether the file of a mesh is there, as it is unless someone removed it.
    async fn has_mesh_file(&self, id: &MeshId) -> Result<bool, StoreError>;

    /// How a mesh is to be read, and the bytes of its file, whole; `None` when the mesh was forgotten.
    async fn mesh_file(
        &self,
        owner: &Owner,
        id: &MeshId,
    ) -> Result<Option<(MeshOptions, Vec<u8>)>, StoreError>;

    /// Keeps a mesh; it is on stable storage once this returns. Says whether it is new. Must be run to its end.
    async fn add_mesh(
        &self,
        received: Received,
        mesh: &NewMesh,
    ) -> Result<Result<(MeshRecord, bool), Refusal>, StoreError>;

    /// Keeps a mesh and a job on it, both or neither; both are on stable storage once this
    /// returns. The record of the mesh may be there already. Must be run to its end.
    async fn add_mesh_and_job(
        &self,
        received: Received,
        mesh: &NewMesh,
        job: &NewJob,
    ) -> Result<Result<JobRecord, Refusal>, StoreError>;

    /// Forgets a mesh unless a job that has not ended needs it. Must be run to its end.
    async fn delete_mesh(&self, owner: &Owner, id: &MeshId) -> Result<Deletion, StoreError>;
}
