//! Delivers the messages in the outbox of the store, as long as the service runs.
//!
//! A delivery is taken under a lease of its own, longer than an attempt can last, and its outcome is written at the
//! end. If the process dies in between, the lease expires and another process, or the next start, delivers once more:
//! receivers recognise repetitions by the id of the message.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use tokio::sync::Mutex;
use tokio::task::{Id, JoinHandle, JoinSet};
use tokio::time::{sleep, timeout};
use tokio_rustls::rustls::{self, RootCertStore};
use tokio_util::sync::CancellationToken;

use super::post::{Failure, Poster, TOTAL_TIME};
use super::{AllowedHosts, Options, Secrets};
use crate::cluster::jittered;
use crate::store::{Attempt, Delivery, SharedStore, StoreError};
use crate::wire::{JobRecord, WebhookEvent};

/// Deliveries under way at the same time.
const AT_ONCE: usize = 16;
/// Most of these deliveries to one host, so that a host that hangs leaves room for the others.
const AT_ONCE_TO_ONE_HOST: usize = 4;
/// Time between two looks at the outbox.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// Pause before a store that failed is tried again.
const STORE_PAUSE: Duration = Duration::from_secs(5);
/// How long a delivery belongs to whoever took it: enough for the attempt and for writing its outcome.
const LEASE: Duration = TOTAL_TIME.saturating_mul(2);
/// Longest time to wait for deliveries under way at a shutdown.
const LAST_DELIVERIES: Duration = Duration::from_secs(3);
/// Longest time beyond that if the store does not answer.
const LAST_WRITES: Duration = Duration::from_secs(1);
/// A pause before the next attempt is shorter or longer at random, within these factors, so that many that failed
/// together do not come back together.
const JITTER: Range<f64> = 0.8..1.2;

/// The task that delivers.
pub struct Sender(Mutex<Option<JoinHandle<()>>>);

impl Sender {
    /// Starts delivering, until `stopping`.
    pub fn start(
        store: SharedStore,
        options: Options,
        stopping: CancellationToken,
    ) -> Result<Self, rustls::Error> {
        let Options {
            hosts,
            private_hosts,
            secrets,
            retries,
        } = options;
        let roots = RootCertStore::from_iter(webpki_roots::TLS_SERVER_ROOTS.iter().cloned());
        let worker = Arc::new(DeliveryWorker {
            store,
            hosts,
            secrets,
            retries,
            poster: Poster::new(roots, private_hosts)?,
        });
        let task = tokio::spawn(deliver_all(worker, stopping));
        Ok(Self(Mutex::new(Some(task))))
    }

    /// Waits for the end of the deliveries under way, for at most some seconds after `stopping`.
    pub async fn ended(&self) {
        let Some(task) = self.0.lock().await.take() else {
            return;
        };
        match timeout(LAST_DELIVERIES + LAST_WRITES, task).await {
            Ok(Ok(())) => {}
            Ok(Err(_)) => tracing::error!("the sender of webhooks ended by a panic"),
            Err(_) => {
                tracing::warn!("the sender of webhooks cannot end, as the store does not answer")
            }
        }
    }
}

async fn deliver_all(worker: Arc<DeliveryWorker>, stopping: CancellationToken) {
    let mut attempts = JoinSet::new();
    let mut hosts: HashMap<Id, String> = HashMap::new();
    while !stopping.is_cancelled() {
        let mut pause = LOOK_EVERY;
        while attempts.len() < AT_ONCE && !stopping.is_cancelled() {
            match worker.store.claim_webhook(&busy(&hosts), LEASE).await {
                Ok(Some(delivery)) => {
                    let host = delivery.host.clone();
                    let worker = Arc::clone(&worker);
                    let attempt = attempts.spawn(async move { worker.deliver(delivery).await });
                    hosts.insert(attempt.id(), host);
                }
                Ok(None) => break,
                Err(fault) => {
                    tracing::error!(%fault, "the outbox of webhooks cannot be read");
                    pause = STORE_PAUSE;
                    break;
                }
            }
        }
        tokio::select! {
            () = stopping.cancelled() => {}
            () = sleep(pause) => {}
            Some(ended) = attempts.join_next_with_id() => {
                let id = match ended {
                    Ok((id, ())) => id,
                    Err(panic) => {
                        tracing::error!(%panic, "the delivery of a webhook ended by a panic");
                        panic.id()
                    }
                };
                hosts.remove(&id);
            }
        }
    }
    let last = async { while attempts.join_next().await.is_some() {} };
    if timeout(LAST_DELIVERIES, last).await.is_err() {
        tracing::info!("webhooks under way are left to the next start");
    }
}

/// Returns the hosts to which as many deliveries are under way as may be.
fn busy(hosts: &HashMap<Id, String>) -> Vec<&str> {
    let mut counts: HashMap<&str, usize> = HashMap::new();
    for host in hosts.values() {
        *counts.entry(host).or_default() += 1;
    }
    counts.retain(|_, count| *count >= AT_ONCE_TO_ONE_HOST);
    counts.into_keys().collect()
}

/// Carries out deliveries.
struct DeliveryWorker {
    store: SharedStore,
    hosts: AllowedHosts,
    secrets: Secrets,
    retries: Vec<Duration>,
    poster: Poster,
}

impl DeliveryWorker {
    async fn deliver(&self, delivery: Delivery) {
        let job = delivery.job;
        if let Err(fault) = self.attempt(&delivery).await {
            tracing::error!(%job, %fault, "the store cannot read or record a webhook; it is tried again");
        }
    }

    async fn attempt(&self, delivery: &Delivery) -> Result<(), StoreError> {
        let Delivery {
            job,
            owner,
            host,
            attempts,
            ..
        } = delivery;
        // Deleted meanwhile, and the delivery with it.
        let Some(record) = self.store.job_without_result(owner, *job).await? else {
            return Ok(());
        };
        let outcome = self.post(delivery, record).await;
        let attempt = match outcome {
            Ok(()) => {
                tracing::info!(%job, host, "webhook delivered");
                Attempt::Delivered
            }
            Err(failure) => {
                let pause = self.retries.get(*attempts as usize);
                match pause.filter(|_| failure != Failure::Gone) {
                    Some(pause) => {
                        let pause = jittered(*pause, JITTER);
                        tracing::warn!(%job, host, %failure, ?pause, "webhook not delivered; it is tried again");
                        Attempt::Failed(failure.to_string(), Some(pause))
                    }
                    None => {
                        tracing::warn!(%job, host, %failure, "webhook not delivered; it is given up");
                        Attempt::Failed(failure.to_string(), None)
                    }
                }
            }
        };
        self.store.record_attempt(delivery, &attempt).await?;
        Ok(())
    }

    async fn post(&self, delivery: &Delivery, record: JobRecord) -> Result<(), Failure> {
        // The operator may have changed the list since the job was submitted.
        let url = self.hosts.check(&delivery.url);
        let url = url.map_err(|_| Failure::NotAllowed)?;
        let event = WebhookEvent::new(record, delivery.has_result);
        let body = serde_json::to_string(&event).map_err(|_| Failure::Broken)?;
        let id = format!("msg_{}", delivery.job);
        let timestamp = Timestamp::now().as_second();
        let headers = [
            ("content-type", "application/json".to_owned()),
            (
                "user-agent",
                concat!("graspd/", env!("CARGO_PKG_VERSION")).to_owned(),
            ),
            ("webhook-timestamp", timestamp.to_string()),
            (
                "webhook-signature",
                self.secrets.sign(&id, timestamp, &body),
            ),
            ("webhook-id", id),
        ];
        self.poster.post(&url, &headers, body).await
    }
}
