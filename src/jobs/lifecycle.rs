//! How a process comes to its end.

use std::time::Duration;

use tokio_util::sync::CancellationToken;

/// The steps in which a process ends, each after the one before it. Clones are the same.
#[derive(Debug, Clone, Default)]
pub struct Lifecycle {
    /// No job is begun any more; those that run go on.
    pub closing: CancellationToken,
    /// All runs stop and put their jobs back.
    pub stopping: CancellationToken,
    /// Everything has been put back.
    pub ended: CancellationToken,
}

impl Lifecycle {
    /// Time between two tries while the store fails.
    ///
    /// Not a crate for retries: a pause has to end early when the process stops, and the last try comes after that.
    pub const STORE_PAUSE: Duration = Duration::from_secs(1);

    /// Waits until a store that fails is to be tried again, or the process stops.
    pub async fn store_pause(&self) {
        let pause = tokio::time::sleep(Self::STORE_PAUSE);
        let _ = self.stopping.run_until_cancelled(pause).await;
    }
}
