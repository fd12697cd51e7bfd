//! One POST to a receiver, to an address that was checked: no redirects, no proxies.
//!
//! The name is resolved once and the connection made to what was found and checked, so that no second answer of the
//! name server can lead elsewhere (DNS rebinding); the TLS certificate must be valid for the name all the same.
//!
//! Written on hyper and not on reqwest, which has a resolver hook but cannot bound the head of an answer to 64 KiB, and
//! does not distinguish a refused address, an unreachable host and a failed handshake.

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use hyper::client::conn::http1;
use hyper::header::HOST;
use hyper::{Request, StatusCode};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpStream, lookup_host};
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::ServerName;
use tokio_rustls::rustls::{self, ClientConfig, RootCertStore};
use url::{Host, Position, Url};

use super::PrivateHosts;
use super::address::is_public;

/// Longest time that the connection to one address may take.
const CONNECT_TIME: Duration = Duration::from_secs(5);
/// Longest time for the whole attempt, from resolving the name to the answer.
pub const TOTAL_TIME: Duration = Duration::from_secs(15);
/// Most bytes of the head of an answer; its body is not read.
const ANSWER_BYTES: usize = 64 * 1024;

/// Why a message was not delivered, in words for whoever submitted the job: they must not reveal anything about the
/// network of the server.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    #[error("the operator of this server no longer allows webhooks to this host")]
    NotAllowed,
    #[error("the name of the host cannot be resolved")]
    Unresolved,
    #[error(
        "the host has an address that is not public, which the operator of this server has to allow"
    )]
    NotPublic,
    #[error("the host cannot be reached")]
    Unreachable,
    #[error("the TLS handshake failed; the certificate has to be valid for the host")]
    Tls,
    #[error("the connection broke off before an answer, or the answer is not HTTP")]
    Broken,
    #[error("no answer came within {} seconds", TOTAL_TIME.as_secs())]
    Late,
    #[error("the receiver answered {0}; redirects are not followed")]
    Redirected(u16),
    #[error("the receiver answered {0}; it must be a status from 200 to 299")]
    Refused(u16),
    #[error("the receiver answered 410: it takes no more webhooks")]
    Gone,
}

/// Sends messages to receivers.
pub struct Poster {
    tls: TlsConnector,
    private: PrivateHosts,
}

impl Poster {
    /// Certificates must come from the authorities in `roots`. Only the hosts in `private` may have addresses that are
    /// not public.
    pub fn new(roots: RootCertStore, private: PrivateHosts) -> Result<Self, rustls::Error> {
        let mut tls = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()?
            .with_root_certificates(roots)
            .with_no_client_auth();
        tls.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self {
            tls: TlsConnector::from(Arc::new(tls)),
            private,
        })
    }

    /// Posts a body with these headers. Takes at most [`TOTAL_TIME`].
    pub async fn post(
        &self,
        url: &Url,
        headers: &[(&'static str, String)],
        body: String,
    ) -> Result<(), Failure> {
        let status = timeout(TOTAL_TIME, self.exchange(url, headers, body));
        match status.await.map_err(|_| Failure::Late)?? {
            status if status.is_success() => Ok(()),
            StatusCode::GONE => Err(Failure::Gone),
            status if status.is_redirection() => Err(Failure::Redirected(status.as_u16())),
            status => Err(Failure::Refused(status.as_u16())),
        }
    }

    async fn exchange(
        &self,
        url: &Url,
        headers: &[(&'static str, String)],
        body: String,
    ) -> Result<StatusCode, Failure> {
        let mut request = Request::post(&url[Position::BeforePath..])
            .header(HOST, &url[Position::BeforeHost..Position::AfterPort]);
        for (name, value) in headers {
            request = request.header(*name, value);
        }
        let request = request.body(body).map_err(|_| Failure::Broken)?;
        let host = url.host().ok_or(Failure::Unresolved)?;
        let port = url.port_or_known_default().ok_or(Failure::Unresolved)?;
        let stream = self.connect(&host, port).await?;
        if url.scheme() == "http" {
            return send(stream, request).await;
        }
        let name = server_name(&host).ok_or(Failure::Tls)?;
        let stream = self.tls.connect(name, stream).await;
        send(stream.map_err(|_| Failure::Tls)?, request).await
    }

    /// Resolves a name once and connects to the first address that answers, if all are allowed.
    async fn connect(&self, host: &Host<&str>, port: u16) -> Result<TcpStream, Failure> {
        let addresses: Vec<SocketAddr> = match host {
            Host::Domain(name) => lookup_host((*name, port))
                .await
                .map_err(|_| Failure::Unresolved)?
                .collect(),
            Host::Ipv4(address) => vec![(*address, port).into()],
            Host::Ipv6(address) => vec![(*address, port).into()],
        };
        // One private address among public ones: the name is not to be trusted.
        let public = addresses.iter().all(|address| is_public(address.ip()));
        if !public && !self.private.contains(host) {
            return Err(Failure::NotPublic);
        }
        for address in addresses {
            if let Ok(Ok(stream)) = timeout(CONNECT_TIME, TcpStream::connect(address)).await {
                return Ok(stream);
            }
        }
        Err(Failure::Unreachable)
    }
}

fn server_name(host: &Host<&str>) -> Option<ServerName<'static>> {
    match host {
        Host::Domain(name) => ServerName::try_from((*name).to_owned()).ok(),
        Host::Ipv4(address) => Some(IpAddr::from(*address).into()),
        Host::Ipv6(address) => Some(IpAddr::from(*address).into()),
    }
}

async fn send<S>(stream: S, request: Request<String>) -> Result<StatusCode, Failure>
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let (mut sender, connection) = http1::Builder::new()
        .max_buf_size(ANSWER_BYTES)
        .handshake(TokioIo::new(stream))
        .await
        .map_err(|_| Failure::Broken)?;
    // Dropped with this future, which ends the connection: once the answer is known, or when time is up.
    let mut driver = JoinSet::new();
    driver.spawn(connection);
    let answer = sender.send_request(request).await;
    Ok(answer.map_err(|_| Failure::Broken)?.status())
}
