//! Messages to one receiver, with and without TLS.

use std::net::Ipv4Addr;
use std::sync::Arc;

use rcgen::{CertifiedKey, generate_simple_self_signed};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivatePkcs8KeyDer};
use tokio_rustls::rustls::{RootCertStore, ServerConfig, crypto::ring};
use url::Url;

use super::post::{Failure, Poster};

/// Starts a receiver on loopback that passes each connection to `serve`.
async fn receiver<F, W>(serve: F) -> u16
where
    F: Fn(tokio::net::TcpStream) -> W + Send + 'static,
    W: Future<Output = ()> + Send,
{
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
    let port = listener.local_addr().unwrap().port();
    tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            serve(stream).await;
        }
    });
    port
}

/// Reads once, and answers with these bytes.
async fn answer(mut stream: impl AsyncRead + AsyncWrite + Unpin, answer: &[u8]) {
    let mut request = vec![0; 4096];
    // A client that refuses the certificate hangs up.
    let _ = stream.read(&mut request).await;
    let _ = stream.write_all(answer).await;
    let _ = stream.flush().await;
}

fn poster(roots: RootCertStore, private: &str) -> Poster {
    Poster::new(roots, private.parse().unwrap()).unwrap()
}

async fn post(poster: &Poster, url: &str) -> Result<(), Failure> {
    let headers = [("webhook-id", "msg_1".to_owned())];
    let url = Url::parse(url).unwrap();
    poster.post(&url, &headers, "{}".to_owned()).await
}

/// Starts a receiver with TLS, and returns its port and certificate.
async fn tls_receiver(name: &str) -> (u16, CertificateDer<'static>) {
    let CertifiedKey { cert, signing_key } =
        generate_simple_self_signed(vec![name.to_owned()]).unwrap();
    let certificate = cert.der().clone();
    let key = PrivatePkcs8KeyDer::from(signing_key.serialize_der());
    let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_no_client_auth()
        .with_single_cert(vec![certificate.clone()], key.into())
        .unwrap();
    let acceptor = TlsAcceptor::from(Arc::new(config));
    let port = receiver(move |stream| {
        let acceptor = acceptor.clone();
        async move {
            if let Ok(stream) = acceptor.accept(stream).await {
                answer(stream, b"HTTP/1.1 204 No Content\r\n\r\n").await;
            }
        }
    })
    .await;
    (port, certificate)
}

#[tokio::test]
async fn a_certificate_is_believed_only_from_an_authority_and_for_its_host() {
    let (port, certificate) = tls_receiver("localhost").await;
    let mut roots = RootCertStore::empty();
    roots.add(certificate).unwrap();
    let trusting = poster(roots, "localhost,127.0.0.1");
    let url = format!("https://localhost:{port}/x");
    assert_eq!(post(&trusting, &url).await, Ok(()));
    // The same receiver under another name.
    let other = format!("https://127.0.0.1:{port}/x");
    assert_eq!(post(&trusting, &other).await, Err(Failure::Tls));
    let (strange, _) = tls_receiver("localhost").await;
    let url = format!("https://localhost:{strange}/x");
    assert_eq!(post(&trusting, &url).await, Err(Failure::Tls));
    let plain = receiver(|stream| answer(stream, b"HTTP/1.1 200 OK\r\n\r\n")).await;
    let url = format!("https://localhost:{plain}/x");
    assert_eq!(post(&trusting, &url).await, Err(Failure::Tls));
}

#[tokio::test]
async fn answers_count_by_their_status_alone() {
    let poster = poster(RootCertStore::empty(), "127.0.0.1");
    let long = format!("HTTP/1.1 200 OK\r\nx: {}\r\n\r\n", "y".repeat(200_000));
    for (given, outcome) in [
        ("HTTP/1.1 200 OK\r\ncontent-length: 2\r\n\r\nok", Ok(())),
        ("HTTP/1.1 204 No Content\r\n\r\n", Ok(())),
        // The body never comes.
        (
            "HTTP/1.1 200 OK\r\ncontent-length: 99999999\r\n\r\n",
            Ok(()),
        ),
        (
            "HTTP/1.1 307 Temporary Redirect\r\nlocation: /y\r\n\r\n",
            Err(Failure::Redirected(307)),
        ),
        ("HTTP/1.1 410 Gone\r\n\r\n", Err(Failure::Gone)),
        ("HTTP/1.1 503 Later\r\n\r\n", Err(Failure::Refused(503))),
        ("SSH-2.0-OpenSSH_9.2\r\n", Err(Failure::Broken)),
        ("", Err(Failure::Broken)),
        (&long, Err(Failure::Broken)),
    ] {
        let bytes = given.as_bytes().to_vec();
        let port = receiver(move |stream| {
            let bytes = bytes.clone();
            async move { answer(stream, &bytes).await }
        })
        .await;
        let found = post(&poster, &format!("http://127.0.0.1:{port}/x")).await;
        assert_eq!(found, outcome, "{}", &given[..given.len().min(80)]);
    }
}

#[tokio::test]
async fn only_what_may_be_private_is_connected_to() {
    let port = receiver(|stream| answer(stream, b"HTTP/1.1 200 OK\r\n\r\n")).await;
    let strict = poster(RootCertStore::empty(), "other.example,*.localhost");
    for host in ["localhost", "127.0.0.1", "[::ffff:127.0.0.1]", "0.0.0.0"] {
        let outcome = post(&strict, &format!("http://{host}:{port}/x")).await;
        assert_eq!(outcome, Err(Failure::NotPublic), "{host}");
    }
    let open = poster(RootCertStore::empty(), "localhost,nowhere.invalid");
    assert_eq!(
        post(&open, &format!("http://localhost:{port}/x")).await,
        Ok(())
    );
    // Reserved so that it never resolves (RFC 6761).
    let nowhere = post(&open, "http://nowhere.invalid/x").await;
    assert_eq!(nowhere, Err(Failure::Unresolved));
    let closed = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
    let port = closed.local_addr().unwrap().port();
    drop(closed);
    let unreachable = post(&open, &format!("http://localhost:{port}/x")).await;
    assert_eq!(unreachable, Err(Failure::Unreachable));
}
