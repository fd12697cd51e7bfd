//! Idempotency keys: however often a submission is sent, it is carried out once.
//!
//! A client chooses a key and sends it with its submission; if the connection breaks, it sends both again. The store
//! remembers for a day what each key was used for, by a fingerprint of everything that the job depends on: the same
//! submission under the same key returns the job that it made, another one is refused. Two at the same moment are kept
//! apart here: the second is refused while the first is being carried out.

use std::collections::HashSet;
use std::sync::Arc;

use parking_lot::Mutex;
use sha2::{Digest, Sha256};

use super::error::Error;
use crate::store::{Owner, Received, Submission};
use crate::wire::{BatchRequest, MeshId, MeshOptions, PlanRequest};

/// The keys of the submissions that are being carried out.
#[derive(Debug, Clone, Default)]
pub struct KeysInUse(Arc<Mutex<HashSet<(Owner, String)>>>);

/// A key in use. While it exists, no other submission of its owner can use it.
#[derive(Debug)]
pub struct IdempotencyKey {
    owner_and_key: (Owner, String),
    in_use: KeysInUse,
    /// Hash of the settings.
    settings: [u8; 32],
}

impl KeysInUse {
    /// Begins a submission, unless one under the same key is being carried out.
    pub fn begin(&self, owner: &Owner, key: &str) -> Result<IdempotencyKey, Error> {
        let owner_and_key = (owner.clone(), key.to_owned());
        if !self.0.lock().insert(owner_and_key.clone()) {
            return Err(Error::InFlight);
        }
        Ok(IdempotencyKey {
            owner_and_key,
            in_use: self.clone(),
            settings: [0; 32],
        })
    }
}

impl IdempotencyKey {
    /// Returns the seed of a request without one. It depends on the key alone, so the repeated request has the same.
    pub fn seed(&self) -> u64 {
        seed(&format!("seed {}", self.key()))
    }

    /// Returns the seed of a job of a batch without one.
    pub fn seed_at(&self, index: usize) -> u64 {
        seed(&format!("seed {} {index}", self.key()))
    }

    /// The key with the settings of a request, as they were sent: before the limits of the server change them.
    pub fn for_request(mut self, request: &PlanRequest) -> Result<Self, Error> {
        let json = serde_json::to_vec(request).map_err(|fault| Error::Bug(fault.to_string()))?;
        self.settings = Sha256::digest(json).into();
        Ok(self)
    }

    /// The key with the settings and the meshes of a batch.
    pub fn for_batch(mut self, batch: &BatchRequest) -> Result<Self, Error> {
        let jobs = batch.jobs.iter().map(|job| (&job.mesh_id, &job.request));
        let parts = (&batch.label, jobs.collect::<Vec<_>>());
        let json = serde_json::to_vec(&parts).map_err(|fault| Error::Bug(fault.to_string()))?;
        self.settings = Sha256::digest(json).into();
        Ok(self)
    }

    /// Returns the submission of a batch.
    pub(super) fn batch_submission(&self) -> Submission {
        self.submission(b"batch")
    }

    /// Returns the submission of a job on a mesh in the store.
    pub(super) fn mesh_submission(&self, mesh: &MeshId) -> Submission {
        self.submission(mesh.as_str().as_bytes())
    }

    /// Returns the submission of a job with a mesh of its own.
    pub(super) fn upload_submission(
        &self,
        received: &Received,
        options: &MeshOptions,
    ) -> Submission {
        self.submission(&received.fingerprint(options))
    }

    fn submission(&self, mesh: &[u8]) -> Submission {
        Submission {
            key: self.key().to_owned(),
            fingerprint: Sha256::new()
                .chain_update(self.settings)
                .chain_update(mesh)
                .finalize()
                .into(),
        }
    }

    fn key(&self) -> &str {
        &self.owner_and_key.1
    }
}

impl Drop for IdempotencyKey {
    fn drop(&mut self) {
        self.in_use.0.lock().remove(&self.owner_and_key);
    }
}

fn seed(text: &str) -> u64 {
    let hash = Sha256::digest(text);
    let bytes = [0, 1, 2, 3, 4, 5, 6, 7].map(|at: usize| hash[at]);
    // 53 bits: exact in every JSON reader.
    u64::from_be_bytes(bytes) >> 11
}
