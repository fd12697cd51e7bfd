//! Listens, accepts connections, and hands their requests to the routes.

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

use super::connection_permits::ConnectionPermits;
use super::socket::Socket;
use crate::http::response::error::Error;
use crate::metrics::Held;

/// The longest that the head of a request may take to arrive, and that a connection may be idle
/// between two requests.
const HEAD_TIME: Duration = Duration::from_secs(15);
/// TCP keep-alive: after a minute of silence the system probes the peer, three times at most. A peer
/// that was unplugged while it waited for an answer is given up after a minute and a half.
const KEEP_ALIVE: TcpKeepalive = TcpKeepalive::new()
    .with_time(Duration::from_secs(60))
    .with_interval(Duration::from_secs(10))
    .with_retries(3);
/// The longest that a peer may read nothing of an answer that is being sent.
const STALL: Duration = Duration::from_secs(30);
/// The longest wait for open connections when the server stops.
const LAST_ANSWERS: Duration = Duration::from_secs(2);
/// The pause after the system failed to accept a connection, for example for want of file handles.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Open files that are not those of connections.
const OTHER_FILES: u64 = 256;

// The layers refuse heads beyond smaller limits with a problem that says which; hyper refuses the
// rest.
const HYPER_MAX_HEADERS: usize = 500;
const HYPER_MAX_HEAD_BYTES: usize = 128 * 1024;

/// Listens on `address` (`HOST:PORT`).
pub async fn listen(address: &str) -> io::Result<(TcpListener, SocketAddr)> {
    let listener = TcpListener::bind(address).await?;
    // Accepted sockets inherit the option.
    SockRef::from(&listener).set_tcp_keepalive(&KEEP_ALIVE)?;
    let local = listener.local_addr()?;
    Ok((listener, local))
}

/// Returns how many files may be open at a time with this many connections: each is one, and may
/// receive an upload into another.
pub fn files_needed(max_connections: usize) -> u64 {
    2 * max_connections as u64 + OTHER_FILES
}

/// Raises the limit on open files to what the connections may need, as far as the system allows.
pub fn raise_file_limit(max_connections: usize) {
    let wanted = files_needed(max_connections);
    match rlimit::increase_nofile_limit(wanted) {
        Ok(limit) if limit >= wanted => {}
        outcome => tracing::warn!(
            wanted,
            ?outcome,
            "the limit on open files is too low for all connections; raise it in the system or lower \
             --max-connections"
        ),
    }
}

/// Serves `router` on at most `max_connections` at a time until `closing`, then gives open
/// connections a moment to finish.
///
/// The gauge `connections` counts those that are open. Requests carry the [`ConnectInfo`] of their
/// peer's [`SocketAddr`]. Connections beyond the bound wait to be accepted; one from a network that
/// has its share of them is refused.
pub async fn serve(
    listener: TcpListener,
    router: Router,
    max_connections: usize,
    closing: CancellationToken,
    connections: Gauge,
) {
    let permits = ConnectionPermits::new(max_connections);
    let open = GracefulShutdown::new();
    let accept = async {
        loop {
            let permit = permits.acquire().await;
            let (stream, peer) = match listener.accept().await {
                Ok(accepted) => accepted,
                Err(fault) => {
                    tracing::warn!(%fault, "cannot accept a connection");
                    tokio::time::sleep(ACCEPT_PAUSE).await;
                    continue;
                }
            };
            let Some(permit) = permits.assign(permit, peer.ip()) else {
                tracing::debug!(%peer, "refused: its network has its share of the connections");
                // Only what the socket takes at once: waiting for the peer would hold up all others.
                let _ = stream.try_write(&Error::too_many_connections().to_raw_response());
                continue;
            };
            let connection = open.watch(connection(stream, peer, router.clone()));
            let held = Held::new(&connections);
            tokio::spawn(async move {
                if let Err(fault) = connection.await {
                    tracing::debug!(%fault, "connection ended early");
                }
                drop((permit, held));
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
    // Most answers are small and should not wait for more bytes to fill a packet.
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
    async fn handlers_know_the_address_of_the_peer() {
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
