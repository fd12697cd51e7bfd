//! Whether the database answers and can be written.

use async_trait::async_trait;

use super::Postgres;
use crate::host;
use crate::metrics::StoreMetrics;
use crate::store::{Health, StoreError};

#[async_trait]
impl Health for Postgres {
    fn metrics(&self) -> &StoreMetrics {
        &self.metrics
    }

    async fn ping(&self) -> Result<(), StoreError> {
        sqlx::query("SELECT 1 FROM compatibility")
            .execute(&self.reads)
            .await?;
        Ok(())
    }

    /// A standby, and one that was set to, only reads. A disk that is full shows with the next write.
    async fn check_writable(&self) -> Result<(), StoreError> {
        let reads_only: bool = sqlx::query_scalar(
            "SELECT pg_is_in_recovery() OR current_setting('transaction_read_only')::boolean",
        )
        .fetch_one(&self.writes)
        .await?;
        match reads_only {
            false => Ok(()),
            true => Err(StoreError::Unwritable("the database only reads")),
        }
    }

    /// Uploads are received into files without a name in the folder for temporary ones.
    async fn check_room(&self, min_free: u64) -> Result<(), StoreError> {
        let free = tokio::task::spawn_blocking(|| host::free_bytes(&std::env::temp_dir()));
        let free = free.await.map_err(std::io::Error::other)??;
        match free >= min_free {
            true => Ok(()),
            false => Err(StoreError::Full),
        }
    }

    async fn close(&self) {
        for connections in [&self.reads, &self.writes, &self.pulse] {
            connections.close().await;
        }
    }
}
