//! Renews the leases of the runs of this process, and recovers the jobs of processes that died.
//!
//! See `lease.rs` for the protocol.

use std::sync::Arc;
use std::time::{Duration, Instant};

use prometheus_client::metrics::counter::Counter;
use tokio::time::sleep;

use super::changes::Changes;
use super::jitter::jittered;
use super::lease::HeldLease;
use crate::store::{Renewal, SharedStore, StoreError};
use crate::wire::Problem;

/// A lease is renewed so many times while it lasts.
const RENEWALS: u32 = 5;
/// Pause before the store is tried again after it failed.
const RETRY: Duration = Duration::from_millis(500);
/// How long the store must have answered without a break before leases that have expired are recovered. After an
/// outage all leases have, and those who hold them need time to come back.
const CALM: Duration = Duration::from_secs(4);

/// Renews and recovers leases.
pub struct LeaseRenewal<F> {
    pub store: SharedStore,
    pub changes: Arc<Changes>,
    /// Returns the leases that this process holds.
    pub held: F,
    pub lease_time: Duration,
    /// How often a job is begun at most, and the problem with which it fails then.
    pub max_attempts: u32,
    pub exhausted: Problem,
    /// Counts the jobs that are recovered.
    pub recovered: Counter,
}

impl<F: Fn() -> Vec<Arc<HeldLease>> + Sync> LeaseRenewal<F> {
    /// Renews leases, for ever.
    pub async fn run(self) {
        let every = self.lease_time / RENEWALS;
        let mut answers_since: Option<Instant> = None;
        loop {
            let pause = match self.renew().await {
                Ok(()) => {
                    let since = *answers_since.get_or_insert_with(Instant::now);
                    if since.elapsed() >= CALM {
                        self.recover().await;
                    }
                    jittered(every, 0.8..1.0)
                }
                Err(error) => {
                    if answers_since.take().is_some() {
                        tracing::error!(%error, "leases cannot be renewed; if that lasts, the runs stop before their leases expire");
                    }
                    RETRY
                }
            };
            sleep(pause).await;
        }
    }

    async fn renew(&self) -> Result<(), StoreError> {
        let leases = (self.held)();
        let renewals: Vec<Renewal> = leases.iter().map(|held| held.renewal()).collect();
        // The lease counts from here, not from the answer.
        let asked = Instant::now();
        let answers = self.store.renew(&renewals).await?;
        for (held, answer) in leases.iter().zip(answers) {
            held.renewed(asked, answer);
        }
        Ok(())
    }

    async fn recover(&self) {
        let recovered = self.store.recover(self.max_attempts, &self.exhausted).await;
        match recovered {
            Ok(jobs) if jobs.is_empty() => {}
            Ok(jobs) => {
                tracing::warn!(
                    jobs = jobs.len(),
                    "recovered the jobs of a process that died"
                );
                self.recovered.inc_by(jobs.len() as u64);
                for job in jobs {
                    self.changes.announce_record(job);
                }
                self.changes.announce_queued();
            }
            Err(error) => {
                tracing::warn!(%error, "the jobs of processes that died cannot be recovered")
            }
        }
    }
}
