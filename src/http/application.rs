//! The whole service, from settings to a listening socket.

use std::net::SocketAddr;
use std::num::NonZeroU32;
use std::sync::Arc;

use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use super::app::App;
use super::layers::auth::AuthLayer;
use super::layers::cors;
use super::options::{requires_keys, server_options};
use super::request::large::LargeBodies;
use super::router::router;
use super::{server, stop};
use crate::config::Config;
use crate::jobs::{Options, Runner, Service};

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

    /// As [`Application::build`]. `adjust` changes options that no setting reaches, and `runner` takes the
    /// place of the planner.
    pub async fn build_with(
        config: &Config,
        adjust: impl FnOnce(&mut Options),
        runner: Option<Arc<Runner>>,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let mut options = server_options(config)?;
        adjust(&mut options);
        server::raise_file_limit(config.max_connections);
        // Listening comes before the store, so that a taken port leaves the data folder untouched.
        let (listener, address) = server::listen(&config.listen)
            .await
            .map_err(|fault| format!("cannot listen on {}: {fault}", config.listen))?;
        let keys = requires_keys(config, address)?;
        let cors = cors::layer(&config.cors_origins)?;
        let service = match runner {
            Some(runner) => Service::start_with(options, runner).await?,
            None => Service::start(options).await?,
        };
        warn_without_keys(&service, keys).await?;
        let app = App {
            auth: Arc::new(AuthLayer::new(service.clone(), keys, rate_limit(config))),
            large_bodies: LargeBodies::default(),
            cors,
            service,
            max_upload_bytes: config.max_upload_bytes,
            max_job_seconds: config.max_job_seconds,
            endpoints: Arc::default(),
        };
        Ok(Self {
            listener,
            address,
            app,
            max_connections: config.max_connections,
        })
    }

    /// The address that it listens on.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The port that it listens on.
    pub fn port(&self) -> u16 {
        self.address.port()
    }

    /// The service behind HTTP.
    pub fn service(&self) -> &Service {
        &self.app.service
    }

    /// Answers requests until `stop`, then ends in this order: new work is refused and running jobs go
    /// back in the queue, requests under way are answered, connections are closed, the store is closed.
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
        // Requests that arrive meanwhile get a 503 instead of a refused connection.
        stop::wait_for_requests(&service).await;
        closing.cancel();
        stop::join_server(serving).await;
        stop::close_store(&service).await;
    }
}

/// The most requests in a minute for each client, `None` for no limit.
fn rate_limit(config: &Config) -> Option<NonZeroU32> {
    let limit = config.rate_limit?;
    NonZeroU32::new(u32::try_from(limit).unwrap_or(u32::MAX))
}

async fn warn_without_keys(
    service: &Service,
    keys: bool,
) -> Result<(), Box<dyn std::error::Error>> {
    if keys && !service.has_keys().await? {
        tracing::warn!(
            "there is no API key yet, so nobody can come in; graspd keys create makes one"
        );
    }
    Ok(())
}
