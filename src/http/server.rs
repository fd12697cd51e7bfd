//! The server: listens, hands connections to the routes, and ends in good order.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use axum::Router;
use axum::extract::ConnectInfo;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::{GracefulConnection, GracefulShutdown};
use hyper_util::service::TowerToHyperService;
use prometheus_client::metrics::gauge::Gauge;
use socket2::{SockRef, TcpKeepalive};
use tokio::net::{TcpListener, TcpStream};
use tokio_util::sync::CancellationToken;

use super::connections::Places;
use super::error::Error;
use super::socket::Socket;
use crate::metrics::Held;

/// Longest that the head of a request may take to arrive, and that a connection may be idle before
/// the next one.
const HEAD_TIME: Duration = Duration::from_secs(15);
/// Silence after which the system asks whether a peer is still there, and how often until it is
/// given up: a minute and a half for one that was unplugged while it waited for an answer.
const KEEP_ALIVE: TcpKeepalive = TcpKeepalive::new()
    .with_time(Duration::from_secs(60))
    .with_interval(Duration::from_secs(10))
    .with_retries(3);
/// Longest that a peer may take nothing of an answer that is being sent.
const STALL: Duration = Duration::from_secs(30);
/// Longest that open connections are waited for at the end.
const LAST_ANSWERS: Duration = Duration::from_secs(2);
/// Pause after the system refused a connection, such as when it is out of file handles.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Open files beside those of connections.
const OTHER_FILES: u64 = 256;

// The layers refuse smaller heads than these with a problem that says more; beyond them hyper
// refuses.
const HYPER_MAX_HEADERS: usize = 500;
const HYPER_MAX_HEAD_BYTES: usize = 128 * 1024;

/// Listens on `address` (`HOST:PORT`).
pub async fn listen(address: &str) -> io::Result<(TcpListener, SocketAddr)> {
    let listener = TcpListener::bind(address).await?;
    // Connections inherit it.
    SockRef::from(&listener).set_tcp_keepalive(&KEEP_ALIVE)?;
    let local = listener.local_addr()?;
    Ok((listener, local))
}

/// Files that may be open at a time on so many connections.
pub fn files_needed(max_connections: usize) -> u64 {
    2 * max_connections as u64 + OTHER_FILES
}

/// Raises the number of files that the process may have open, as far as the system lets it: each
/// connection is one and may receive into another.
pub fn make_room(max_connections: usize) {
    let wanted = files_needed(max_connections);
    match rlimit::increase_nofile_limit(wanted) {
        Ok(limit) if limit >= wanted => {}
        outcome => tracing::warn!(
            wanted,
            ?outcome,
            "too few open files are allowed for all connections; raise the limit of the system or \
             lower --max-connections"
        ),
    }
}

/// Serves `router` on at most `max_connections` at a time until `closing`, then gives open
/// connections a moment to finish.
///
/// `connections` counts those that are open. Requests carry [`ConnectInfo`] of the peer's [`SocketAddr`]. Connections beyond the bound wait
/// to be accepted; one from an address that has its share of them is refused.
pub async fn serve(
    listener: TcpListener,
    router: Router,
    max_connections: usize,
    closing: CancellationToken,
    connections: Gauge,
) {
    let places = Places::new(max_connections);
    let open = GracefulShutdown::new();
    let accept = async {
        loop {
            let permit = places.free().await;
            let (stream, peer) = match listener.accept().await {
                Ok(accepted) => accepted,
                Err(fault) => {
                    tracing::warn!(%fault, "cannot accept a connection");
                    tokio::time::sleep(ACCEPT_PAUSE).await;
                    continue;
                }
            };
            let Some(place) = places.take(permit, peer.ip()) else {
                tracing::debug!(%peer, "refused: its address has its share of the connections");
                // As far as it goes out at once: nobody waits for the peer to take it.
                let _ = stream.try_write(&Error::crowded().on_the_wire());
                continue;
            };
            let connection = open.watch(connection(stream, peer, router.clone()));
            let held = Held::new(&connections);
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
    peer: SocketAddr,
    router: Router,
) -> impl GracefulConnection<Output = Result<(), hyper::Error>> {
    // Answers are small and should not wait for more to send.
    let _ = stream.set_nodelay(true);
    let routes = TowerToHyperService::new(router);
    let service = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(ConnectInfo(peer));
        routes.call(request)
    });
    http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIME)
        .max_headers(HYPER_MAX_HEADERS)
        .max_header_size(HYPER_MAX_HEAD_BYTES)
        .serve_connection(TokioIo::new(Socket::new(stream, STALL)), service)
}

#[cfg(test)]
mod tests {
    use axum::routing::get;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    use super::*;

    #[tokio::test]
    async fn handlers_know_who_asks() {
        async fn echo(ConnectInfo(peer): ConnectInfo<SocketAddr>) -> String {
            peer.to_string()
        }
        let (listener, address) = listen("127.0.0.1:0").await.unwrap();
        let closing = CancellationToken::new();
        let router = Router::new().route("/", get(echo));
        let serving = tokio::spawn(serve(
            listener,
            router,
            10,
            closing.clone(),
            Gauge::default(),
        ));
        let mut stream = TcpStream::connect(address).await.unwrap();
        let own = stream.local_addr().unwrap().to_string();
        stream
            .write_all(b"GET / HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n")
            .await
            .unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await.unwrap();
        assert!(answer.ends_with(&own), "{answer}");
        closing.cancel();
        serving.await.unwrap();
    }
}
