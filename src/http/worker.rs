//! A process that only plans. Where `--listen` is given it also answers health checks and Prometheus.

use std::net::SocketAddr;

use axum::Router;
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use super::layers::{self, request_metrics};
use super::options::planning_options;
use super::server;
use super::stop;
use super::system::{metrics, status};
use crate::config::WorkerConfig;
use crate::jobs::{Location, Role, Service};

/// The most connections at a time; only monitoring connects here.
const MAX_CONNECTIONS: usize = 32;

/// A worker that plans already and does not answer yet.
pub struct WorkerApplication {
    service: Service,
    listener: Option<(TcpListener, SocketAddr)>,
}

impl WorkerApplication {
    /// Connects to the database and starts to plan.
    pub async fn build(config: &WorkerConfig) -> Result<Self, Box<dyn std::error::Error>> {
        if config.planning.workers == 0 {
            return Err("--workers 0: a process that only plans needs at least one".into());
        }
        let listener = match &config.listen {
            None => None,
            Some(address) => Some(
                server::listen(address)
                    .await
                    .map_err(|fault| format!("cannot listen on {address}: {fault}"))?,
            ),
        };
        let store = Location::Database(config.store.clone());
        let options = planning_options(store, Role::Worker, &config.planning);
        Ok(Self {
            service: Service::start(options).await?,
            listener,
        })
    }

    /// The address that it listens on, if it does.
    pub fn address(&self) -> Option<SocketAddr> {
        self.listener.as_ref().map(|(_, address)| *address)
    }

    /// The service behind it.
    pub fn service(&self) -> &Service {
        &self.service
    }

    /// Plans until `stop`. Then it starts no more jobs, lets those that run go on for as long as the settings allow,
    /// puts the rest back in the queue, and ends.
    pub async fn run_until_stopped(self, stop: impl Future<Output = ()>) {
        let Self { service, listener } = self;
        let closing = CancellationToken::new();
        let serving = listener.map(|(listener, _)| {
            let connections = service.metrics().http.connections.clone();
            let router = router(service.clone());
            let closing = closing.clone();
            tokio::spawn(server::serve(
                listener,
                router,
                MAX_CONNECTIONS,
                closing,
                connections,
            ))
        });
        stop.await;
        service.shutdown().await;
        closing.cancel();
        if let Some(serving) = serving {
            stop::join_server(serving).await;
        }
        stop::close_store(&service).await;
    }
}

/// The routes of a worker.
fn router(service: Service) -> Router {
    let measure = from_fn_with_state(service.clone(), request_metrics::measure);
    let routes = Router::new()
        .route("/healthz", get(status::healthz))
        .route("/readyz", get(status::readyz))
        .route("/metrics", get(metrics::metrics))
        .with_state(service);
    layers::wrap(routes).layer(measure)
}
