//! Forgets what is kept for too long, now and then.

use std::sync::Arc;
use std::time::Duration;

use super::pool::Shared;

/// Pause between two sweeps, within these bounds a twentieth of the retention.
const PAUSE: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(60)];

/// Sweeps until the server stops.
pub async fn sweep(shared: Arc<Shared>, retention: Duration) {
    let pause = (retention / 20).clamp(PAUSE[0], PAUSE[1]);
    let stopping = &shared.stopping;
    while stopping
        .run_until_cancelled(tokio::time::sleep(pause))
        .await
        .is_some()
    {
        match shared.store.expire(retention).await {
            Ok(expired) if expired == Default::default() => {}
            Ok(expired) => tracing::info!(
                jobs = expired.jobs,
                meshes = expired.meshes,
                "removed what expired"
            ),
            Err(error) => tracing::error!(%error, "what expired cannot be removed"),
        }
    }
}
