//! The whole service, from settings to a listening socket.

use std::net::SocketAddr;
use std::time::Duration;

use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use super::{App, router, server};
use crate::config::Config;
use crate::core::mesh::Limits;
use crate::jobs::{IntakeLimits, Options, Service};

/// How often a job is started at most when the server dies while it runs.
const MAX_ATTEMPTS: u32 = 3;

/// A service that listens but does not answer yet.
pub struct Application {
    listener: TcpListener,
    address: SocketAddr,
    app: App,
}

impl Application {
    /// Opens the data folder, puts interrupted jobs back in the queue, and listens.
    pub async fn build(config: &Config) -> Result<Self, Box<dyn std::error::Error>> {
        let (listener, address) = server::listen(&config.listen)
            .await
            .map_err(|fault| format!("cannot listen on {}: {fault}", config.listen))?;
        let service = Service::start(options(config)).await?;
        Ok(Self {
            listener,
            address,
            app: App {
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
            closing.clone(),
            connections,
        ));
        stop.await;
        service.shutdown().await;
        closing.cancel();
        if serving.await.is_err() {
            tracing::error!("the server ended by a panic");
        }
        service.close().await;
    }
}

fn options(config: &Config) -> Options {
    Options {
        data_dir: config.data_dir.clone(),
        workers: config.workers,
        threads_per_job: config.job_threads(),
        queue_capacity: config.queue_capacity.try_into().unwrap_or(u32::MAX),
        intake: IntakeLimits {
            mesh: Limits {
                triangles: config.max_triangles,
                vertices: config.max_vertices,
                memory: usize::try_from(config.max_mesh_memory).unwrap_or(usize::MAX),
            },
            time: Duration::from_secs_f64(config.max_parse_seconds),
        },
        max_attempts: MAX_ATTEMPTS,
        min_free_disk: config.min_free_disk,
    }
}
