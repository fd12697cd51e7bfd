//! Batches: many jobs queued, watched, stopped and forgotten as one.

use std::collections::HashMap;

use async_trait::async_trait;

use super::jobs::Refusal;
use super::meshes::MeshSummary;
use super::submissions::Submission;
use super::{Owner, StoreError};
use crate::wire::{
    BatchId, BatchPage, BatchRecord, BatchResult, JobId, JobState, MeshId, Priority,
};

/// Jobs that are to be queued together.
#[derive(Debug)]
pub struct NewBatch {
    pub owner: Owner,
    pub label: Option<String>,
    pub jobs: Vec<BatchedJob>,
    /// The most jobs that may be queued, these among them.
    pub capacity: u32,
    /// The most jobs of this owner among them.
    pub owner_capacity: Option<u32>,
    /// The key that it is submitted under, so that it is queued only once.
    pub submission: Option<Submission>,
}

/// A job of a batch.
#[derive(Debug)]
pub struct BatchedJob {
    pub mesh_id: MeshId,
    /// The effective settings, as JSON.
    pub request: String,
    pub label: Option<String>,
    pub priority: Priority,
}

/// The batches of a store.
#[async_trait]
pub trait Batches {
    /// Returns what jobs need to know of those of these meshes that the owner has.
    async fn mesh_summaries(
        &self,
        owner: &Owner,
        meshes: &[MeshId],
    ) -> Result<HashMap<MeshId, MeshSummary>, StoreError>;

    /// Queues all jobs of a batch, in their order, or none; they are on stable storage once this returns them.
    /// Must be run to its end.
    async fn submit_batch(
        &self,
        batch: &NewBatch,
    ) -> Result<Result<BatchRecord, Refusal>, StoreError>;

    /// Returns a batch of an owner. Costs time proportional to the number of its jobs, about a millisecond for 10,000.
    async fn batch(&self, owner: &Owner, id: BatchId) -> Result<Option<BatchRecord>, StoreError>;

    /// Returns at most `limit` batches of an owner, newest first, from where `cursor` ended; `None` when the
    /// cursor is not one of this list. Costs time proportional to the number of jobs in these batches.
    async fn batches(
        &self,
        owner: &Owner,
        cursor: Option<&str>,
        limit: u32,
    ) -> Result<Option<BatchPage>, StoreError>;

    /// Returns a job of a batch that has not ended: of those that wait the last one, which is likely to be the
    /// last to end.
    async fn unfinished(&self, id: BatchId) -> Result<Option<JobId>, StoreError>;

    /// Returns at most `limit` jobs of a batch, in its order, with their results; only those behind the index
    /// `after` and in `state`, where given.
    async fn batch_results(
        &self,
        owner: &Owner,
        id: BatchId,
        state: Option<JobState>,
        after: Option<u32>,
        limit: u32,
    ) -> Result<Vec<BatchResult>, StoreError>;

    /// Ends the queued jobs of a batch, and marks the running ones so that they end as cancelled. Returns those
    /// that it changed with the revisions of their records.
    async fn cancel_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Vec<(JobId, u64)>, StoreError>;

    /// Forgets a batch and its jobs, whatever their states, and returns these; `None` when there is no such
    /// batch.
    async fn delete_batch(
        &self,
        owner: &Owner,
        id: BatchId,
    ) -> Result<Option<Vec<JobId>>, StoreError>;

    /// Returns whether a batch was here and has expired with the last of its jobs.
    async fn batch_has_expired(&self, owner: &Owner, id: BatchId) -> Result<bool, StoreError>;
}
