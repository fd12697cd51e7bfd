//! Whether a store can do its work.

use async_trait::async_trait;

use super::StoreError;
use crate::metrics::StoreMetrics;

/// How a store is.
#[async_trait]
pub trait Health {
    /// The numbers of this store.
    fn metrics(&self) -> &StoreMetrics;

    /// Fails unless the store answers.
    async fn ping(&self) -> Result<(), StoreError>;

    /// Fails unless the store can be written.
    async fn check_writable(&self) -> Result<(), StoreError>;

    /// Fails as on a full disk when fewer than `min_free` bytes are left where uploads are received.
    async fn check_room(&self, min_free: u64) -> Result<(), StoreError>;

    /// Closes the connections, waiting for statements under way.
    async fn close(&self);
}
