//! Reads on after an early answer, so that a client which is still sending gets to read it.

use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::body::{Body, BodyDataStream, HttpBody};
use axum::extract::Request;
use axum::http::header::EXPECT;
use futures_util::{Stream, StreamExt};

/// How much of an unread body, and for how long, is read after the answer. Closing the connection with
/// unread bytes would reset it, and the client might never see why it was refused.
const DRAIN_BYTES: u64 = 256 << 20;
const DRAIN_TIME: Duration = Duration::from_secs(15);

/// Makes the body one whose rest is read in the background when it is dropped, whoever answers and
/// however much of it was read.
pub fn linger(request: Request) -> Request {
    let untouched = request.headers().contains_key(EXPECT);
    request.map(|body| {
        Body::from_stream(Lingering {
            stream: (!body.is_end_stream()).then(|| body.into_data_stream()),
            untouched,
        })
    })
}

/// A body whose rest is read when it is dropped.
struct Lingering {
    /// `None` once it has ended.
    stream: Option<BodyDataStream>,
    /// Whether the sender still waits for `100 Continue`, which reading would send.
    untouched: bool,
}

impl Stream for Lingering {
    type Item = <BodyDataStream as Stream>::Item;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context) -> Poll<Option<Self::Item>> {
        self.untouched = false;
        let Some(stream) = &mut self.stream else {
            return Poll::Ready(None);
        };
        let piece = ready!(stream.poll_next_unpin(context));
        if !matches!(piece, Some(Ok(_))) {
            self.stream = None;
        }
        Poll::Ready(piece)
    }
}

impl Drop for Lingering {
    fn drop(&mut self) {
        if let (false, Some(stream), Ok(runtime)) = (
            self.untouched,
            self.stream.take(),
            tokio::runtime::Handle::try_current(),
        ) {
            runtime.spawn(drain(stream));
        }
    }
}

async fn drain(mut stream: BodyDataStream) {
    let mut left = DRAIN_BYTES;
    let read = async {
        while let Some(Ok(piece)) = stream.next().await {
            left = left.saturating_sub(piece.len() as u64);
            if left == 0 {
                break;
            }
        }
    };
    let _ = tokio::time::timeout(DRAIN_TIME, read).await;
}
