//! Forgets what is kept for too long, now and then.

use std::sync::Arc;
use std::time::Duration;

use super::pool::Shared;
use crate::store::{Expired, SharedStore, StoreError};

/// Pause between two sweeps, within these bounds a twentieth of the retention.
const PAUSE: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(60)];

/// Sweeps until the server stops. Without a `retention` only what is needed no more goes.
pub async fn sweep(shared: Arc<Shared>, retention: Option<Duration>) {
    let pause = retention.map_or(PAUSE[1], |retention| retention / 20);
    let pause = pause.clamp(PAUSE[0], PAUSE[1]);
    let stopping = &shared.stopping;
    while stopping
        .run_until_cancelled(tokio::time::sleep(pause))
        .await
        .is_some()
    {
        if let Err(error) = forget(&shared.store, retention).await {
            tracing::error!(%error, "what expired cannot be removed");
        }
    }
}

async fn forget(store: &SharedStore, retention: Option<Duration>) -> Result<(), StoreError> {
    store.forget_submissions().await?;
    if let Some(retention) = retention {
        let Expired { jobs, meshes } = store.expire(retention).await?;
        if jobs + meshes > 0 {
            tracing::info!(jobs, meshes, "removed what expired");
        }
    }
    Ok(())
}
