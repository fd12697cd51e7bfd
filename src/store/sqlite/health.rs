//! Checks that the folder and its database can be read and written.

use std::time::Duration;

use async_trait::async_trait;

use super::Sqlite;
use crate::metrics::StoreMetrics;
use crate::store::{Health, StoreError};

/// How old the last write may be for the store to count as writable without another.
const PROBE_EVERY: Duration = Duration::from_secs(5);

#[async_trait]
impl Health for Sqlite {
    fn metrics(&self) -> &StoreMetrics {
        &self.metrics
    }

    async fn ping(&self) -> Result<(), StoreError> {
        let statement = sqlx::query("SELECT 1 FROM jobs LIMIT 1");
        self.readers.read(statement).await?;
        Ok(())
    }

    /// Writes a page where nothing has been written for some seconds.
    async fn check_writable(&self) -> Result<(), StoreError> {
        let proven = || {
            let written = self.writer.written();
            written.is_some_and(|at| at.elapsed() < PROBE_EVERY)
        };
        if proven() {
            return Ok(());
        }
        let _one = self.probe.lock().await;
        if !proven() {
            // Nobody reads that number, but it is written and synced like everything else.
            let statement = sqlx::query("PRAGMA user_version = 1");
            self.writer.run(statement).await?;
            self.writer.note_written();
        }
        Ok(())
    }

    /// Sets room aside for writes that must not fail, while there is enough.
    async fn check_free_space(&self, min_free: u64) -> Result<(), StoreError> {
        let free = self.free_bytes().await?;
        let spare = free.checked_sub(min_free).ok_or(StoreError::Full)?;
        self.keep_reserve(spare).await;
        Ok(())
    }

    async fn close(&self) {
        self.readers.close().await;
        self.writer.close().await;
    }
}
