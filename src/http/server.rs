//! The server: listens, hands connections to the routes, and ends in good order.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use prometheus_client::metrics::gauge::Gauge;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;

use crate::metrics::Held;

/// Most connections open at a time; more wait to be accepted.
pub const MAX_CONNECTIONS: usize = 1024;
/// Longest that the head of a request may take to arrive.
const HEAD_TIME: Duration = Duration::from_secs(15);
/// Longest that open connections are waited for at the end.
const LAST_ANSWERS: Duration = Duration::from_secs(8);
/// Pause after the system refused a connection, such as when it is out of file handles.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

// The layers refuse smaller heads than these with a problem; beyond them hyper answers 431 or
// 414 in its own name, without a body.
const HYPER_MAX_HEADERS: usize = 500;
const HYPER_MAX_HEAD_BYTES: usize = 128 * 1024;

/// Listens on `address` (`HOST:PORT`).
pub async fn listen(address: &str) -> io::Result<(TcpListener, SocketAddr)> {
    let listener = TcpListener::bind(address).await?;
    let local = listener.local_addr()?;
    Ok((listener, local))
}

/// Serves `router` until `closing`, then gives open connections a moment to finish. `connections`
/// counts those that are open.
pub async fn serve(
    listener: TcpListener,
    router: Router,
    closing: CancellationToken,
    connections: Gauge,
) {
    let places = Arc::new(Semaphore::new(MAX_CONNECTIONS));
    let open = GracefulShutdown::new();
    let accept = async {
        // The semaphore is never closed.
        while let Ok(place) = Arc::clone(&places).acquire_owned().await {
            let stream = match listener.accept().await {
                Ok((stream, _)) => stream,
                Err(fault) => {
                    tracing::warn!(%fault, "cannot accept a connection");
                    tokio::time::sleep(ACCEPT_PAUSE).await;
                    continue;
                }
            };
            let held = Held::new(&connections);
            let connection = open.watch(connection(stream, router.clone()));
            tokio::spawn(async move {
                if let Err(fault) = connection.await {
                    tracing::debug!(%fault, "connection ended early");
                }
                drop((place, held));
            });
        }
    };
    closing.run_until_cancelled(accept).await;
    drop(listener);
    if tokio::time::timeout(LAST_ANSWERS, open.shutdown())
        .await
        .is_err()
    {
        tracing::warn!("some connections were still open at the end");
    }
}

fn connection(
    stream: TcpStream,
    router: Router,
) -> http1::Connection<TokioIo<TcpStream>, TowerToHyperService<Router>> {
    // Answers are small and should not wait for more to send.
    let _ = stream.set_nodelay(true);
    http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIME)
        .max_headers(HYPER_MAX_HEADERS)
        .max_header_size(HYPER_MAX_HEAD_BYTES)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router))
}
