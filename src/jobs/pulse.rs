//! Keeps the leases of the jobs that run here, and takes up those whose holders died.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::time::sleep;

use super::control::{Control, Stop};
use super::pool::Shared;
use crate::store::{Hold, Standing, StoreError};
use crate::wire::Problem;

/// Leases are renewed so many times while they last.
const BEATS: u32 = 5;
/// The part of a lease after which a run that could not renew it stops: before another may begin.
const FENCE: f64 = 0.8;
/// Pause before the store is tried again after it failed.
const RETRY: Duration = Duration::from_millis(500);
/// How long the store must have answered without a break before the dead are told from those who cannot reach
/// it either: time for all of these to come back.
const CALM: Duration = Duration::from_secs(4);

/// How long after the last renewal a run is to stop.
pub fn fence(lease_time: Duration) -> Duration {
    lease_time.mul_f64(FENCE)
}

/// Renews leases until the process stops, and takes up the jobs of the dead for at most `max_attempts`, after which
/// they fail with `exhausted`.
pub async fn beat(
    shared: Arc<Shared>,
    lease_time: Duration,
    max_attempts: u32,
    exhausted: Problem,
) {
    let every = lease_time / BEATS;
    let mut answers_since: Option<Instant> = None;
    let work = async {
        loop {
            let pause = match renew(&shared).await {
                Ok(()) => {
                    let since = *answers_since.get_or_insert_with(Instant::now);
                    if since.elapsed() >= CALM {
                        take_up(&shared, max_attempts, &exhausted).await;
                    }
                    // Not all processes at the same moment.
                    every.mul_f64(0.8 + super::random() * 0.2)
                }
                Err(error) => {
                    if answers_since.take().is_some() {
                        tracing::error!(%error, "leases cannot be renewed; runs stop in time if that lasts");
                    }
                    RETRY
                }
            };
            sleep(pause).await;
        }
    };
    // While the process ends, too, until its last job is put back.
    let _ = shared.ended.run_until_cancelled(work).await;
}

async fn renew(shared: &Shared) -> Result<(), StoreError> {
    let runs = shared.running.all();
    let standing = |control: &Arc<Control>| {
        let (revision, progress) = control.live();
        Standing {
            lease: control.lease.clone(),
            revision,
            progress,
        }
    };
    let standings: Vec<_> = runs.iter().map(standing).collect();
    // From here on, and not from when the answer came.
    let asked = Instant::now();
    let holds = shared.store.renew(&standings).await?;
    for (control, hold) in runs.iter().zip(holds) {
        match hold {
            Hold::Held => control.renewed(asked),
            Hold::Cancelled => {
                control.renewed(asked);
                control.raise(Stop::Cancel);
            }
            Hold::Lost => control.raise(Stop::Discard),
        }
    }
    Ok(())
}

async fn take_up(shared: &Shared, max_attempts: u32, exhausted: &Problem) {
    match shared.store.recover(max_attempts, exhausted).await {
        Ok(jobs) if jobs.is_empty() => {}
        Ok(jobs) => {
            tracing::warn!(
                jobs = jobs.len(),
                "took up the jobs of a process that is silent"
            );
            shared.metrics.jobs.taken_up.inc_by(jobs.len() as u64);
            for job in jobs {
                shared.changes.stored(job);
            }
            shared.tell_queued();
        }
        Err(error) => tracing::warn!(%error, "jobs of silent processes cannot be taken up"),
    }
}
