//! The socket of one connection, between TCP and hyper.
//!
//! It does two things that hyper does not:
//!
//! - It gives up on a peer that stops reading. hyper would hold the connection, its permit and the
//!   buffered answer for as long as the peer keeps it open.
//! - It replaces the answers that hyper writes itself to a request whose head it cannot read. These
//!   are a bare status, and every error of this service is a problem. hyper has no hook for them
//!   (hyperium/hyper#3225), so they are recognised by what the answers of the routes never are: an
//!   error without a body and without a request id, in one write. Should a later version of hyper
//!   write them otherwise, clients get the bare status.
//!
//! After such a refusal the rest of what the peer sends is read for a moment: closing a socket with
//! unread bytes resets the connection, and the peer might never see why it was refused.

use std::io::{self, IoSlice};
use std::pin::{Pin, pin};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::http::StatusCode;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::Sleep;

use crate::http::layers::request_log::REQUEST_ID;
use crate::http::response::error::Error;

/// How long, and how much of, what a refused peer still sends is read after the refusal.
const LINGER: Duration = Duration::from_secs(2);
const LINGER_BYTES: usize = 1 << 20;

/// A TCP stream with a bound on how long its peer may read nothing.
pub struct Socket {
    stream: TcpStream,
    /// The longest that the peer may read nothing of what is being sent.
    patience: Duration,
    /// Runs while the peer reads nothing.
    stall: Option<Pin<Box<Sleep>>>,
    refusal: Option<Refusal>,
}

/// The answer that replaces hyper's own; the connection ends with it.
struct Refusal {
    answer: Vec<u8>,
    sent: usize,
    /// Set once the answer is sent.
    linger: Option<Pin<Box<Sleep>>>,
    discarded: usize,
}

impl Socket {
    /// Writes fail once the peer has read nothing for `patience`.
    pub fn new(stream: TcpStream, patience: Duration) -> Self {
        Self {
            stream,
            patience,
            stall: None,
            refusal: None,
        }
    }

    fn stream(&mut self) -> Pin<&mut TcpStream> {
        Pin::new(&mut self.stream)
    }

    /// Returns the outcome of a write, or an error once the peer has read nothing for too long.
    fn or_stalled(
        &mut self,
        context: &mut Context<'_>,
        written: Poll<io::Result<usize>>,
    ) -> Poll<io::Result<usize>> {
        if written.is_ready() {
            self.stall = None;
            return written;
        }
        let stall = self
            .stall
            .get_or_insert_with(|| Box::pin(tokio::time::sleep(self.patience)));
        ready!(stall.as_mut().poll(context));
        Poll::Ready(Err(io::ErrorKind::TimedOut.into()))
    }

    /// Sends the refusal instead of the `bare` bytes of hyper, and reports those as written once it is out.
    fn refuse(
        &mut self,
        context: &mut Context<'_>,
        status: StatusCode,
        bare: usize,
    ) -> Poll<io::Result<usize>> {
        let mut refusal = self.refusal.take().unwrap_or_else(|| Refusal {
            answer: Error::unreadable_head(status).to_raw_response(),
            sent: 0,
            linger: None,
            discarded: 0,
        });
        let mut written = Poll::Ready(Ok(bare));
        while refusal.sent < refusal.answer.len() {
            let rest = &refusal.answer[refusal.sent..];
            match self.stream().poll_write(context, rest) {
                Poll::Ready(Ok(0)) => {
                    written = Poll::Ready(Err(io::ErrorKind::WriteZero.into()));
                    break;
                }
                Poll::Ready(Ok(count)) => refusal.sent += count,
                other => {
                    written = other;
                    break;
                }
            }
        }
        self.refusal = Some(refusal);
        self.or_stalled(context, written)
    }
}

/// Returns the status of an answer that hyper wrote itself, `None` for one of the routes.
fn bare_status(answer: &[u8]) -> Option<StatusCode> {
    let text = std::str::from_utf8(answer).ok()?;
    let status: StatusCode = text.strip_prefix("HTTP/1.")?.get(2..5)?.parse().ok()?;
    let is_bare = text.ends_with("\r\n\r\n")
        && text.contains("content-length: 0\r\n")
        && !text.contains(REQUEST_ID.as_str());
    let is_error = status.is_client_error() || status.is_server_error();
    (is_bare && is_error).then_some(status)
}

impl AsyncRead for Socket {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        self.stream().poll_read(context, buffer)
    }
}

impl AsyncWrite for Socket {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        if let Some(status) = bare_status(bytes) {
            return self.refuse(context, status, bytes.len());
        }
        let written = self.stream().poll_write(context, bytes);
        self.or_stalled(context, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        pieces: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        if let [piece] = pieces
            && let Some(status) = bare_status(piece)
        {
            return self.refuse(context, status, piece.len());
        }
        let written = self.stream().poll_write_vectored(context, pieces);
        self.or_stalled(context, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.stream().poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let Self {
            stream, refusal, ..
        } = &mut *self;
        let Some(refusal) = refusal else {
            return Pin::new(stream).poll_shutdown(context);
        };
        if refusal.linger.is_none() {
            ready!(Pin::new(&mut *stream).poll_shutdown(context))?;
        }
        let linger = refusal
            .linger
            .get_or_insert_with(|| Box::pin(tokio::time::sleep(LINGER)));
        let mut scrap = [0; 4096];
        while linger.as_mut().poll(context).is_pending() && refusal.discarded < LINGER_BYTES {
            let mut buffer = ReadBuf::new(&mut scrap);
            ready!(pin!(&mut *stream).poll_read(context, &mut buffer))?;
            match buffer.filled().len() {
                0 => break,
                count => refusal.discarded += count,
            }
        }
        Poll::Ready(Ok(()))
    }
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::net::TcpListener;

    use super::*;

    #[tokio::test]
    async fn a_peer_that_does_not_read_is_given_up_and_a_slow_one_is_not() {
        let patience = Duration::from_millis(300);
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let mut peer = TcpStream::connect(listener.local_addr().unwrap())
            .await
            .unwrap();
        let (stream, _) = listener.accept().await.unwrap();
        let writing = tokio::spawn(async move {
            let mut socket = Socket::new(stream, patience);
            let piece = vec![0; 1 << 20];
            let mut sent = 0;
            loop {
                match socket.write_all(&piece).await {
                    Ok(()) => sent += piece.len(),
                    Err(fault) => return (sent, fault.kind()),
                }
            }
        });
        let mut piece = vec![0; 1 << 20];
        let mut taken = 0;
        for _ in 0..20 {
            tokio::time::sleep(patience / 6).await;
            taken += peer.read(&mut piece).await.unwrap();
        }
        assert!(!writing.is_finished() && taken > 0);
        let (_, fault) = writing.await.unwrap();
        assert_eq!(fault, io::ErrorKind::TimedOut);
    }

    #[test]
    fn only_an_answer_without_body_and_without_id_is_bare() {
        let head = "HTTP/1.1 431 Request Header Fields Too Large\r\ncontent-length: 0\r\n";
        let bare = |rest: &str| bare_status(format!("{head}{rest}").as_bytes());
        assert_eq!(
            bare("connection: close\r\n\r\n"),
            Some(StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE)
        );
        assert_eq!(bare("x-request-id: 1\r\n\r\n"), None);
        assert_eq!(bare("\r\n\r\nHTTP/1.1 200 OK"), None);
        assert_eq!(bare_status(b"HTTP/1.1 100 Continue\r\n\r\n"), None);
        assert_eq!(bare_status(b""), None);
    }
}
