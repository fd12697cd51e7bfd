//! Checks that the database answers and can be written.

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
        let statement = sqlx::query("SELECT 1 FROM compatibility");
        self.reads.run(statement).await?;
        Ok(())
    }

    /// A standby only reads, and so does a database that was set to. A full disk shows with the next write.
    async fn check_writable(&self) -> Result<(), StoreError> {
        let statement = sqlx::query(
            "SELECT pg_is_in_recovery() OR current_setting('transaction_read_only')::boolean",
        );
        let (reads_only,) = self.writes.run(statement).await?.one()?;
        match reads_only {
            false => Ok(()),
            true => Err(StoreError::Unwritable("the database only reads")),
        }
    }

    /// Uploads are received into files without a name in the folder for temporary ones.
    async fn check_free_space(&self, min_free: u64) -> Result<(), StoreError> {
        let free = tokio::task::spawn_blocking(|| host::free_bytes(&std::env::temp_dir()));
        let free = free.await.map_err(std::io::Error::other)??;
        match free >= min_free {
            true => Ok(()),
            false => Err(StoreError::Full),
        }
    }

    async fn close(&self) {
        for connections in [&self.reads, &self.writes, &self.urgent] {
            connections.close().await;
        }
    }
}
