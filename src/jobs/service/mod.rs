//! [`Service`], the one entrance to meshes, jobs and batches.
//!
//! `start` puts the parts together, `state` is what they become; the other files are its operations by subject.

mod batches;
mod evaluations;
mod follow;
mod job_counts;
mod jobs;
mod meshes;
mod pictures;
mod readiness;
mod slots;
mod start;
mod state;
mod submissions;

pub use follow::Follower;
pub use meshes::MeshUpload;
pub use state::Service;
