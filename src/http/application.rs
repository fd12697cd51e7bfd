//! The whole service, from settings to a listening socket.

use std::net::SocketAddr;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use super::access::Gate;
use super::{App, body, cors, router, server};
use crate::config::{Auth, Config, Period, Planning};
use crate::jobs::{Location, Options, PlanningOptions, Quota, Role, Runner, Service, webhooks};

/// Longest that requests under way are waited for at the end, while others are answered.
const LAST_REQUESTS: Duration = Duration::from_secs(6);
/// Longest that the store is waited for at the end.
pub(super) const LAST_STATEMENTS: Duration = Duration::from_secs(3);

/// How often a job is started at most when the process dies while it runs.
const MAX_ATTEMPTS: u32 = 3;

/// A service that listens but does not answer yet.
pub struct Application {
    listener: TcpListener,
    address: SocketAddr,
    app: App,
    max_connections: usize,
}

impl Application {
    /// Opens the data folder, puts interrupted jobs back in the queue, and listens.
    pub async fn build(config: &Config) -> Result<Self, Box<dyn std::error::Error>> {
        Self::build_with(config, |_| {}, None).await
    }

    /// As [`Application::build`], with options that no setting reaches changed by `adjust` and, where given,
    /// `runner` in the place of the planner.
    pub async fn build_with(
        config: &Config,
        adjust: impl FnOnce(&mut Options),
        runner: Option<Arc<Runner>>,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let mut options = options(config)?;
        adjust(&mut options);
        server::make_room(config.max_connections);
        let (listener, address) = server::listen(&config.listen)
            .await
            .map_err(|fault| format!("cannot listen on {}: {fault}", config.listen))?;
        let keys = wants_keys(config, address)?;
        let cors = cors::layer(&config.cors_origins)?;
        let service = match runner {
            Some(runner) => Service::start_with(options, runner).await?,
            None => Service::start(options).await?,
        };
        if keys && !service.has_keys().await? {
            tracing::warn!(
                "there is no API key yet, so nobody can come in; graspd keys create makes one"
            );
        }
        let rate_limit = config
            .rate_limit
            .map(|limit| u32::try_from(limit).unwrap_or(u32::MAX))
            .and_then(NonZeroU32::new);
        Ok(Self {
            listener,
            address,
            max_connections: config.max_connections,
            app: App {
                gate: Arc::new(Gate::new(service.clone(), keys, rate_limit)),
                large_bodies: body::places(),
                cors,
                service,
                max_upload_bytes: config.max_upload_bytes,
                max_job_seconds: config.max_job_seconds,
            },
        })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The port it listens on.
    pub fn port(&self) -> u16 {
        self.address.port()
    }

    /// The door to meshes and jobs beside HTTP.
    pub fn service(&self) -> &Service {
        &self.app.service
    }

    /// Answers until `stop`; then refuses new work, puts running jobs back in the queue while it
    /// still answers, and ends.
    pub async fn run_until_stopped(self, stop: impl Future<Output = ()>) {
        let service = self.app.service.clone();
        let connections = service.metrics().http.connections.clone();
        let closing = CancellationToken::new();
        let serving = tokio::spawn(server::serve(
            self.listener,
            router(self.app),
            self.max_connections,
            closing.clone(),
            connections,
        ));
        stop.await;
        service.shutdown().await;
        // Those who ask meanwhile are told, rather than turned away.
        let requests = &service.metrics().http.in_flight;
        let deadline = Instant::now() + LAST_REQUESTS;
        while requests.get() > 0 && Instant::now() < deadline {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        closing.cancel();
        if serving.await.is_err() {
            tracing::error!("the server ended by a panic");
        }
        if tokio::time::timeout(LAST_STATEMENTS, service.close())
            .await
            .is_err()
        {
            tracing::warn!("the store was still busy at the end");
        }
    }
}

/// Whether API keys are wanted at `address`.
pub fn wants_keys(config: &Config, address: SocketAddr) -> Result<bool, String> {
    match config.auth {
        Some(auth) => Ok(auth == Auth::Keys),
        None if address.ip().to_canonical().is_loopback() => Ok(false),
        None => Err(format!(
            "{} can be reached from other machines: say --auth keys and make a key with graspd keys create, or \
             --auth off if anyone who can connect may use it",
            config.listen
        )),
    }
}

fn options(config: &Config) -> Result<Options, String> {
    let planning = &config.planning;
    if planning.workers == 0 && config.store.store.is_none() {
        return Err("--workers 0 plans nothing where no other process can: give it a worker, or a database that \
                    workers share in --store"
            .to_owned());
    }
    Ok(Options {
        queue_capacity: config.queue_capacity.try_into().unwrap_or(u32::MAX),
        quota: Quota {
            queued: Some(config.max_queued_per_key.try_into().unwrap_or(u32::MAX)),
            mesh_bytes: Some(config.max_mesh_bytes_per_key),
        },
        retention: match config.retention {
            Period::For(time) => Some(time),
            Period::Forever => None,
        },
        // Those who wait must never keep out those who work.
        followers: (config.max_connections / 4).max(1),
        webhooks: webhooks::Options::new(
            config.webhook_hosts.clone(),
            config.webhook_private_hosts.clone(),
            config.webhook_secret.as_ref(),
        )?,
        min_free_disk: config.min_free_disk,
        ..planning_options(config.store.location(), Role::Server, planning)
    })
}

/// Of a process that plans so, with no bounds on its clients and nobody to call.
pub(super) fn planning_options(store: Location, role: Role, planning: &Planning) -> Options {
    Options {
        store,
        role,
        planning: PlanningOptions {
            workers: planning.workers,
            threads_per_job: planning.job_threads(),
            max_attempts: MAX_ATTEMPTS,
            max_memory: planning.memory_limit(),
            drain: planning.drain,
        },
        queue_capacity: u32::MAX,
        quota: Quota::default(),
        retention: None,
        ingest: planning.ingest_limits(),
        followers: 1,
        min_free_disk: 0,
        webhooks: webhooks::Options::default(),
    }
}
