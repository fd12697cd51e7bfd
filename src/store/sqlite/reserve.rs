//! Room on the disk that is set aside for writes that must not fail for want of it.
//!
//! A cancellation or the end of a run was promised to a client, and has to be written even on a full disk. A file of
//! fixed size takes that room from everyone else. When such a write finds the disk full, the file is removed and the
//! write is tried once more.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parking_lot::Mutex;

use super::{Sqlite, blocking};
use crate::host;
use crate::store::StoreError;

/// Room for some hundred cancellations, or for the results of some dozen jobs.
const RESERVE_BYTES: u64 = 4 << 20;

/// The file that takes the room.
#[derive(Debug, Clone)]
pub struct Reserve {
    path: PathBuf,
    /// Whether it exists, whole. Locked while it is written or removed.
    held: Arc<Mutex<bool>>,
}

impl Reserve {
    pub fn open(data: &Path) -> Self {
        let path = data.join("graspd.db-reserve");
        let whole = fs::metadata(&path).is_ok_and(|file| file.len() == RESERVE_BYTES);
        Self {
            path,
            held: Arc::new(Mutex::new(whole)),
        }
    }

    fn is_held(&self) -> bool {
        *self.held.lock()
    }

    /// Writes the file, all or nothing. Blocks.
    fn fill(&self) -> io::Result<()> {
        let mut held = self.held.lock();
        if *held {
            return Ok(());
        }
        let write = || -> io::Result<()> {
            let mut file = File::create(&self.path)?;
            let zeros = [0; 64 * 1024];
            (0..RESERVE_BYTES / zeros.len() as u64).try_for_each(|_| file.write_all(&zeros))
        };
        let written = write();
        match written {
            Ok(()) => *held = true,
            Err(_) => drop(fs::remove_file(&self.path)),
        }
        written
    }

    /// Removes the file. Returns whether there was one.
    pub fn spend(&self) -> bool {
        let mut held = self.held.lock();
        std::mem::take(&mut *held) && fs::remove_file(&self.path).is_ok()
    }
}

impl Sqlite {
    /// Returns how many bytes may still be written to the file system of the data directory.
    pub(super) async fn free_bytes(&self) -> Result<u64, StoreError> {
        let folder = self.files.folder().to_owned();
        blocking(move || host::free_bytes(&folder)).await
    }

    /// Sets room aside again when it was spent and `spare` bytes are free for it.
    pub(super) async fn keep_reserve(&self, spare: u64) {
        if spare < RESERVE_BYTES || self.reserve.is_held() {
            return;
        }
        let reserve = self.reserve.clone();
        if let Err(error) = blocking(move || reserve.fill()).await {
            tracing::warn!(%error, "no room can be kept for writes on a full disk");
        }
    }

    /// Runs a write that must not fail for want of room. When it does, runs it once more with the room that is set
    /// aside.
    pub(super) async fn with_reserve<T, F>(&self, write: impl Fn() -> F) -> Result<T, StoreError>
    where
        F: Future<Output = Result<T, StoreError>>,
    {
        match write().await {
            Err(StoreError::Full) => {
                let reserve = self.reserve.clone();
                if blocking(move || Ok(reserve.spend())).await? {
                    tracing::warn!("the disk is full: the room kept for that is spent");
                }
                // Even if there was none left: another write may have spent it just now.
                write().await
            }
            outcome => outcome,
        }
    }
}
