//! Deletes what has been kept for long enough.

use std::time::Duration;

use tokio_util::sync::CancellationToken;

use crate::store::{Expired, SharedStore, StoreError};

/// Bounds of the pause between two sweeps, which is a twentieth of the retention.
const PAUSE: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(60)];

/// Sweeps until the process stops. Without a `retention` only submissions that are no longer remembered go.
pub async fn sweep(store: SharedStore, retention: Option<Duration>, stopping: CancellationToken) {
    let pause = retention.map_or(PAUSE[1], |retention| retention / 20);
    let pause = pause.clamp(PAUSE[0], PAUSE[1]);
    while stopping
        .run_until_cancelled(tokio::time::sleep(pause))
        .await
        .is_some()
    {
        if let Err(error) = delete_expired(&store, retention).await {
            tracing::error!(%error, "expired jobs and meshes cannot be deleted");
        }
    }
}

async fn delete_expired(
    store: &SharedStore,
    retention: Option<Duration>,
) -> Result<(), StoreError> {
    store.forget_submissions().await?;
    if let Some(retention) = retention {
        let Expired { jobs, meshes } = store.expire(retention).await?;
        if jobs + meshes > 0 {
            tracing::info!(jobs, meshes, "deleted expired jobs and meshes");
        }
    }
    Ok(())
}
