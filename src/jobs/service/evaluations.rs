//! Grasps evaluated while the client waits.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::state::{Inner, Service};
use crate::jobs::error::Error;
use crate::jobs::ingest;
use crate::run::{self, EvaluationFault};
use crate::store::{Owner, StoreError, Upload};
use crate::wire::{EvaluationRequest, Evaluations, MeshId, MeshOptions, Problem};
use graspd_core::mesh::Mesh;
use graspd_core::{Interrupt, Interrupted};

/// Longest computation for one request.
const TIME_LIMIT: Duration = Duration::from_secs(30);

impl Service {
    /// Evaluates grasps on a mesh in the store. The computation stops when the caller is dropped.
    pub async fn evaluate(
        &self,
        owner: &Owner,
        mesh_id: &str,
        request: EvaluationRequest,
    ) -> Result<Evaluations, Error> {
        let mesh_id = MeshId::parse(mesh_id).ok_or(Error::UnknownMesh)?;
        self.0.check_open()?;
        let mesh = self.0.prepared_mesh(owner, &mesh_id).await?;
        self.0.evaluate(mesh, request).await
    }

    /// Evaluates grasps on an uploaded mesh, which is not kept.
    pub async fn evaluate_upload(
        &self,
        upload: Upload,
        options: MeshOptions,
        request: EvaluationRequest,
    ) -> Result<Evaluations, Error> {
        self.0.check_open()?;
        let slot = self.0.slots.upload()?;
        let mut received = upload.finish().await?;
        let mesh = {
            let permit = self.0.slots.ingest().await?;
            let limits = self.0.context.limits;
            let work = move || -> Result<Mesh, Error> {
                let _permits = (slot, permit);
                let bytes = received.read().map_err(StoreError::from)?;
                let prepared = ingest::prepare_mesh(bytes, &options, &limits);
                Ok(prepared.map_err(Error::Refused)?.1)
            };
            tokio::task::spawn_blocking(work)
                .await
                .map_err(Error::bug)??
        };
        self.0.evaluate(Arc::new(mesh), request).await
    }
}

impl Inner {
    /// Returns a mesh of the store, from memory or from its file.
    pub(super) async fn prepared_mesh(
        &self,
        owner: &Owner,
        id: &MeshId,
    ) -> Result<Arc<Mesh>, Error> {
        // The mesh in memory may be another owner's.
        let kept = self.store.mesh_summary(owner, id).await?;
        let kept = kept.ok_or(Error::UnknownMesh)?;
        // On a full disk the answer is worth more than the note.
        let every = self.limits.mark_used_every;
        if let Err(error) = self.store.mark_used(owner, id, &kept, every).await {
            tracing::warn!(mesh = %id, %error, "the use of a mesh cannot be recorded");
        }
        if let Some(mesh) = self.context.meshes.get(id) {
            return Ok(mesh);
        }
        let permit = self.slots.ingest().await?;
        let file = self.store.mesh_file(owner, id).await?;
        let (options, bytes) = file.ok_or(Error::UnknownMesh)?;
        let limits = self.context.limits;
        let work = move || {
            let _permit = permit;
            ingest::prepare_mesh(bytes, &options, &limits)
        };
        let prepared = tokio::task::spawn_blocking(work)
            .await
            .map_err(Error::bug)?;
        let mesh = Arc::new(prepared.map_err(Error::Refused)?.1);
        self.context.meshes.put(id.clone(), Arc::clone(&mesh));
        Ok(mesh)
    }

    async fn evaluate(
        &self,
        mesh: Arc<Mesh>,
        request: EvaluationRequest,
    ) -> Result<Evaluations, Error> {
        let permit = self.slots.evaluation().await?;
        let interest = Interest::default();
        let lost = Arc::clone(&interest.lost);
        let evaluators = Arc::clone(&self.evaluators);
        let work = move || {
            let _permit = permit;
            let start = Instant::now();
            let ask = || {
                if lost.load(Ordering::Relaxed) {
                    return Some(Interrupted::Cancelled);
                }
                (start.elapsed() >= TIME_LIMIT).then_some(Interrupted::TimeLimit)
            };
            evaluators.install(|| run::evaluate(&mesh, &request, Interrupt::new(&ask)))
        };
        let found = tokio::task::spawn_blocking(work)
            .await
            .map_err(Error::bug)?;
        found.map_err(|fault| match fault {
            EvaluationFault::Problem(problem) => Error::Refused(problem),
            // After a cancellation nobody reads the answer.
            EvaluationFault::Interrupted(_) => Error::Refused(too_long()),
        })
    }
}

/// Sets its flag when the future that holds it is dropped, as when a client hangs up.
#[derive(Default)]
struct Interest {
    lost: Arc<AtomicBool>,
}

impl Drop for Interest {
    fn drop(&mut self) {
        self.lost.store(true, Ordering::Relaxed);
    }
}

fn too_long() -> Problem {
    Problem::new(
        422,
        "too-much-work",
        "Too much work for one call",
        format!(
            "these grasps take longer than {} s; send fewer of them in one call, use fewer cone edges, \
             or request fewer analyses of them",
            TIME_LIMIT.as_secs()
        ),
    )
}
