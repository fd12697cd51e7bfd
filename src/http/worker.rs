//! A process that only plans: no socket but, where wanted, one for those who look after it.

use std::net::SocketAddr;

use axum::Router;
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use super::application::{LAST_STATEMENTS, planning_options};
use super::{layers, meter, server, system};
use crate::config::WorkerConfig;
use crate::jobs::{Location, Role, Service};

/// Connections of those who look after it, at a time.
const MAX_CONNECTIONS: usize = 32;

/// A worker that plans already, and does not answer yet.
pub struct WorkerApplication {
    service: Service,
    listener: Option<(TcpListener, SocketAddr)>,
}

impl WorkerApplication {
    /// Connects to the database and begins to plan.
    pub async fn build(config: &WorkerConfig) -> Result<Self, Box<dyn std::error::Error>> {
        if config.planning.workers == 0 {
            return Err("--workers 0: a process that only plans needs one at least".into());
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

    /// Where it answers, if it does.
    pub fn address(&self) -> Option<SocketAddr> {
        self.listener.as_ref().map(|(_, address)| *address)
    }

    pub fn service(&self) -> &Service {
        &self.service
    }

    /// Plans until `stop`; then begins no job any more, lets those that run go on for as long as they may, puts the
    /// rest back in the queue, and ends.
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
        if let Some(serving) = serving
            && serving.await.is_err()
        {
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

/// What those who look after a worker ask.
fn router(service: Service) -> Router {
    let measure = from_fn_with_state(service.clone(), meter::measure);
    let routes = Router::new()
        .route("/healthz", get(system::healthz))
        .route("/readyz", get(system::readyz))
        .route("/metrics", get(meter::metrics))
        .with_state(service);
    layers::wrap(routes).layer(measure)
}
