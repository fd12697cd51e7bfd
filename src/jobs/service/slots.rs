//! How much work of each kind is done at the same time, and how much may wait for that.

use std::sync::Arc;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::jobs::error::Error;

/// Uploads that are read and prepared at the same time; each may take several times the size of its file in memory.
const INGESTS: usize = 2;
/// Uploads that have arrived and wait to be read, each with its file on the disk.
const UPLOADS: usize = 256;
/// Requests for evaluations that are computed at the same time.
const EVALUATIONS: usize = 2;
/// Pictures that are drawn at the same time; each may take a hundred megabytes.
const PICTURES: usize = 2;
/// Large pictures that wait for their turn, the one that is drawn included.
const LARGE_PICTURES: usize = 16;

/// Slots for work. Whoever does some keeps its permits until it is done, even when nobody waits for it any more.
pub struct Slots {
    uploads: Arc<Semaphore>,
    ingests: Arc<Semaphore>,
    evaluations: Arc<Semaphore>,
    pictures: Arc<Semaphore>,
    large_pictures: Arc<Semaphore>,
    large_picture: Arc<Semaphore>,
}

/// Permits to draw a picture.
pub struct PicturePermits {
    _large: Option<(OwnedSemaphorePermit, OwnedSemaphorePermit)>,
    _picture: OwnedSemaphorePermit,
}

impl Slots {
    /// All slots are free.
    pub fn new() -> Self {
        let slots = |count| Arc::new(Semaphore::new(count));
        Self {
            uploads: slots(UPLOADS),
            ingests: slots(INGESTS),
            evaluations: slots(EVALUATIONS),
            pictures: slots(PICTURES),
            large_pictures: slots(LARGE_PICTURES),
            large_picture: slots(1),
        }
    }

    /// Returns a slot for an upload that has arrived, or refuses it. The work goes on when its sender hangs up, and must not pile up.
    pub fn upload(&self) -> Result<OwnedSemaphorePermit, Error> {
        try_acquire(
            &self.uploads,
            "as many meshes wait to be read as may; send it again in a moment",
        )
    }

    /// Waits for the permission to read and prepare a mesh.
    pub async fn ingest(&self) -> Result<OwnedSemaphorePermit, Error> {
        acquire(&self.ingests).await
    }

    /// Waits for the permission to evaluate grasps.
    pub async fn evaluation(&self) -> Result<OwnedSemaphorePermit, Error> {
        acquire(&self.evaluations).await
    }

    /// Waits for the turn of a large picture; refused when too many wait. Large ones are drawn one after the other, so
    /// that there is always a slot for the others.
    pub async fn large_picture(
        &self,
    ) -> Result<(OwnedSemaphorePermit, OwnedSemaphorePermit), Error> {
        let waiting = try_acquire(
            &self.large_pictures,
            "as many large pictures wait to be drawn as may; ask again in a moment, or for a smaller one",
        )?;
        Ok((waiting, acquire(&self.large_picture).await?))
    }

    /// Waits for the permission to draw a picture.
    pub async fn picture(
        &self,
        large: Option<(OwnedSemaphorePermit, OwnedSemaphorePermit)>,
    ) -> Result<PicturePermits, Error> {
        Ok(PicturePermits {
            _large: large,
            _picture: acquire(&self.pictures).await?,
        })
    }
}

fn try_acquire(
    slots: &Arc<Semaphore>,
    refusal: &'static str,
) -> Result<OwnedSemaphorePermit, Error> {
    let permit = Arc::clone(slots).try_acquire_owned();
    permit.map_err(|_| Error::Unready {
        kind: "busy",
        detail: refusal,
    })
}

async fn acquire(slots: &Arc<Semaphore>) -> Result<OwnedSemaphorePermit, Error> {
    Arc::clone(slots).acquire_owned().await.map_err(Error::bug)
}
