//! Meshes: taken in, read, listed, forgotten.

use std::time::Duration;

use async_trait::async_trait;

use super::jobs::{NewJob, Refusal};
use super::uploads::{Received, Upload};
use super::{Owner, StoreError};
use crate::wire::{JobRecord, MeshId, MeshOptions, MeshPage, MeshRecord, Units};
use graspd_core::mesh::MeshReport;
use graspd_mesh_io::MeshFormat;

/// A mesh whose file has been received and found usable.
#[derive(Debug)]
pub struct NewMesh {
    pub owner: Owner,
    pub format: MeshFormat,
    pub units: Option<Units>,
    pub scale: f64,
    pub file_name: Option<String>,
    pub report: MeshReport,
    /// The most bytes that the files of its owner's meshes may have in all.
    pub max_owner_bytes: Option<u64>,
}

/// What a job needs to know of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct MeshSummary {
    /// How many triangles a finger may be put on.
    pub candidates: u64,
    /// Bodies that do not touch each other.
    pub bodies: u64,
    pub units: Option<Units>,
    /// When the mesh was last asked for, in microseconds since 1970.
    pub(super) used_at: i64,
}

/// What came of the deletion of a mesh.
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
    /// Returns an empty file to receive a mesh into; it is removed unless it becomes one.
    async fn begin_upload(&self) -> Result<Upload, StoreError>;

    /// Returns the record of a mesh of an owner.
    async fn mesh(&self, owner: &Owner, id: &MeshId) -> Result<Option<MeshRecord>, StoreError>;

    /// Returns what a job needs to know of a mesh, if its owner has it.
    async fn mesh_summary(
        &self,
        owner: &Owner,
        id: &MeshId,
    ) -> Result<Option<MeshSummary>, StoreError>;

    /// Writes down that a mesh was asked for, unless the time written is newer than `every`.
    async fn mark_used(
        &self,
        owner: &Owner,
        id: &MeshId,
        kept: &MeshSummary,
        every: Duration,
    ) -> Result<(), StoreError>;

    /// Returns the bytes of the files of all meshes of an owner.
    async fn mesh_bytes(&self, owner: &Owner) -> Result<u64, StoreError>;

    /// Returns at most `limit` meshes of an owner, newest first, from where `cursor` ended; `None` when the cursor
    /// is not one of this list.
    async fn meshes(
        &self,
        owner: &Owner,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<MeshPage>, StoreError>;

    /// Returns whether the file of a mesh exists, as it does unless someone removed it.
    async fn has_mesh_file(&self, id: &MeshId) -> Result<bool, StoreError>;

    /// Returns how a mesh is to be read, and the bytes of its file, whole; `None` when the mesh was forgotten.
    async fn mesh_file(
        &self,
        owner: &Owner,
        id: &MeshId,
    ) -> Result<Option<(MeshOptions, Vec<u8>)>, StoreError>;

    /// Keeps a mesh; it is on stable storage once this returns. Returns whether its owner did not have it before. Must be run to its end.
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
