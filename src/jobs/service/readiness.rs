//! Whether new work is accepted and can be done.

use std::time::Duration;

use super::state::{Inner, Service};
use crate::jobs::error::Error;
use crate::store::StoreError;

/// Longest time to wait for the store.
const PATIENCE: Duration = Duration::from_millis(800);

impl Service {
    /// Succeeds if new work is accepted and done. Takes at most a second even when the store hangs.
    ///
    /// Fails with the cause otherwise: the service drains, the process takes as much memory as it may, a worker is gone,
    /// the store cannot be read or written (tried by a real write, where none succeeded lately), or the disk is full or
    /// nearly so.
    pub async fn ready(&self) -> Result<(), Error> {
        self.0.check_open()?;
        self.0.check_memory()?;
        if self.0.pool.has_lost_workers() {
            return Err(Error::WorkerLost);
        }
        match tokio::time::timeout(PATIENCE, self.0.check_store()).await {
            Ok(outcome) => outcome,
            Err(_) => Err(unready("store-slow", "the store does not answer in time")),
        }
    }
}

impl Inner {
    async fn check_store(&self) -> Result<(), Error> {
        self.store.ping().await.map_err(|fault| {
            tracing::error!(%fault, "the store cannot be read");
            unready(
                "store-unreadable",
                "the store cannot be read; see the log of the server for the cause",
            )
        })?;
        self.check_room().await.map_err(|fault| match fault {
            StoreError::Full => unready(
                "disk-low",
                "less disk space is free than the server has to keep free; free some",
            ),
            fault => fault.into(),
        })?;
        self.store.check_writable().await.map_err(|fault| {
            tracing::error!(%fault, "the store cannot be written");
            match fault {
                StoreError::Full => unready("disk-full", "the disk is full; free some space"),
                _ => unready(
                    "store-unwritable",
                    "the store cannot be written; see the log of the server for the cause",
                ),
            }
        })
    }

    /// Fails as on a full disk when less space is free than has to be.
    pub(super) async fn check_room(&self) -> Result<(), StoreError> {
        self.store.check_free_space(self.limits.min_free_disk).await
    }
}

fn unready(kind: &'static str, detail: &'static str) -> Error {
    Error::Unready { kind, detail }
}
