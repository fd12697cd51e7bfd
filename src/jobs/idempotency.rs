//! Submissions that are carried out once, however often they are sent.

use std::collections::HashSet;
use std::sync::{Arc, Mutex, PoisonError};

use sha2::{Digest, Sha256};

use super::error::Error;
use crate::store::{Owner, Received, Submission};
use crate::wire::{BatchRequest, MeshId, MeshOptions, PlanRequest};

/// The keys of the submissions that are being carried out now.
#[derive(Debug, Clone, Default)]
pub struct InFlight(Arc<Mutex<HashSet<(Owner, String)>>>);

/// A submission under an Idempotency-Key. While it exists no other one under the same key does.
#[derive(Debug)]
pub struct IdempotencyKey {
    place: (Owner, String),
    in_flight: InFlight,
    /// Hash of the settings.
    settings: [u8; 32],
}

impl InFlight {
    /// Begins a submission.
    pub fn begin(&self, owner: &Owner, key: &str) -> Result<IdempotencyKey, Error> {
        let place = (owner.clone(), key.to_owned());
        let mut taken = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !taken.insert(place.clone()) {
            return Err(Error::InFlight);
        }
        Ok(IdempotencyKey {
            place,
            in_flight: self.clone(),
            settings: [0; 32],
        })
    }
}

impl IdempotencyKey {
    /// The seed of a request that names none. It hangs on the key, so that the repeated request is the same.
    pub fn seed(&self) -> u64 {
        seed(&format!("seed {}", self.place.1))
    }

    /// The seed of the job at a place of a batch, for a request that names none.
    pub fn seed_at(&self, index: usize) -> u64 {
        seed(&format!("seed {} {index}", self.place.1))
    }

    /// Takes note of what is asked for, before the limits of the server shape it.
    pub fn for_request(mut self, request: &PlanRequest) -> Result<Self, Error> {
        let json = serde_json::to_vec(request).map_err(|fault| Error::Bug(fault.to_string()))?;
        self.settings = Sha256::digest(json).into();
        Ok(self)
    }

    /// As [`IdempotencyKey::for_request`], for a batch: its meshes are a part of what is asked for.
    pub fn for_batch(mut self, batch: &BatchRequest) -> Result<Self, Error> {
        let jobs = batch.jobs.iter().map(|job| (&job.mesh_id, &job.request));
        let parts = (&batch.label, jobs.collect::<Vec<_>>());
        let json = serde_json::to_vec(&parts).map_err(|fault| Error::Bug(fault.to_string()))?;
        self.settings = Sha256::digest(json).into();
        Ok(self)
    }

    /// This submission of a batch.
    pub(super) fn batch_submission(&self) -> Submission {
        self.submission(b"batch")
    }

    /// This submission for a mesh that is here.
    pub(super) fn mesh_submission(&self, mesh: &MeshId) -> Submission {
        self.submission(mesh.as_str().as_bytes())
    }

    /// This submission with a mesh that came along.
    pub(super) fn upload_submission(
        &self,
        received: &Received,
        options: &MeshOptions,
    ) -> Submission {
        self.submission(&received.fingerprint(options))
    }

    fn submission(&self, mesh: &[u8]) -> Submission {
        Submission {
            key: self.place.1.clone(),
            fingerprint: Sha256::new()
                .chain_update(self.settings)
                .chain_update(mesh)
                .finalize()
                .into(),
        }
    }
}

fn seed(text: &str) -> u64 {
    let hash = Sha256::digest(text);
    let bytes = [0, 1, 2, 3, 4, 5, 6, 7].map(|at: usize| hash[at]);
    // Exact in every JSON reader.
    u64::from_be_bytes(bytes) >> 11
}

impl Drop for IdempotencyKey {
    fn drop(&mut self) {
        let mut taken = self
            .in_flight
            .0
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        taken.remove(&self.place);
    }
}
