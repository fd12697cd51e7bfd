//! Whether a store can do its work.

use async_trait::async_trait;

use super::StoreError;
use crate::metrics::StoreMetrics;

/// The health of a store.
#[async_trait]
pub trait Health {
    /// Returns the metrics of this store.
    fn metrics(&self) -> &StoreMetrics;

    /// Fails unless the store answers.
    async fn ping(&self) -> Result<(), StoreError>;

    /// Fails unless the store can be written.
    async fn check_writable(&self) -> Result<(), StoreError>;

    /// Fails as on a full disk when fewer than `min_free` bytes are left where uploads are received.
    async fn check_free_space(&self, min_free: u64) -> Result<(), StoreError>;

    /// Closes the connections, waiting for statements under way.
    async fn close(&self);
}
