//! Request bodies as streams that are never longer nor slower than allowed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use axum::body::{Body, BodyDataStream, Bytes};
use axum::extract::Request;
use axum::http::header::CONTENT_LENGTH;
use futures_util::{Stream, StreamExt, stream};

use crate::http::response::error::Error;

/// The longest wait for the next [`WINDOW_BYTES`] of a body, or for its end: 1 KiB/s on average.
const WINDOW: Duration = Duration::from_secs(15);
const WINDOW_BYTES: u64 = 15 * 1024;

/// Why a body could not be read to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum BodyFault {
    /// Longer than the limit.
    #[error("body too large")]
    TooLarge,
    /// Fewer than [`WINDOW_BYTES`] in [`WINDOW`].
    #[error("body too slow")]
    TooSlow,
    /// The connection ended before the body did, or its framing is broken.
    #[error("body broken")]
    Broken,
    /// The headers of one part of a form exceed the budget set with [`ByteBudget::start`].
    #[error("part headers too large")]
    PartHeaders,
}

impl BodyFault {
    /// Finds the fault among the sources of an error that travelled through other libraries.
    pub fn source_of(error: &(dyn std::error::Error + 'static)) -> Option<Self> {
        let mut link = Some(error);
        while let Some(error) = link {
            if let Some(fault) = error.downcast_ref::<Self>() {
                return Some(*fault);
            }
            link = error.source();
        }
        None
    }

    /// Returns the refusal, where `limit` is the most bytes that were allowed.
    pub fn refusal(self, limit: u64) -> Error {
        match self {
            Self::TooLarge => Error::too_large(format!("the body may have at most {limit} bytes")),
            Self::TooSlow => Error::too_slow(),
            Self::Broken => Error::bad_request("the body ended early or is badly framed"),
            Self::PartHeaders => {
                Error::too_large("the headers of one part may have at most 8192 bytes")
            }
        }
    }
}

/// A bound on how many bytes a parser may take from a body before it has found what it looks for,
/// shared between the stream that counts and the reader that sets it.
#[derive(Clone, Default)]
pub struct ByteBudget(Arc<Counts>);

#[derive(Default)]
struct Counts {
    taken: AtomicU64,
    /// The value of `taken` at which the stream fails; 0 is none.
    stop: AtomicU64,
}

impl ByteBudget {
    /// Lets the reader take `bytes` more; the stream fails when it asks for more after that.
    pub fn start(&self, bytes: u64) {
        let taken = self.0.taken.load(Ordering::Relaxed);
        self.0.stop.store(taken + bytes, Ordering::Relaxed);
    }

    /// Lifts the bound.
    pub fn lift(&self) {
        self.0.stop.store(0, Ordering::Relaxed);
    }

    fn is_spent(&self) -> bool {
        let stop = self.0.stop.load(Ordering::Relaxed);
        stop != 0 && self.0.taken.load(Ordering::Relaxed) >= stop
    }
}

/// Turns a body into a stream that fails beyond `limit` bytes and when the body comes too slowly.
///
/// The stream yields to the runtime after every piece: a reader that takes whatever is ready would
/// otherwise hold all that a fast client sends.
pub fn limited(
    body: Body,
    limit: u64,
    budget: ByteBudget,
) -> impl Stream<Item = Result<Bytes, BodyFault>> + Send + 'static {
    let source = Source {
        stream: Some(body.into_data_stream()),
        left: limit,
        budget,
        pace: Pace::default(),
    };
    stream::try_unfold(source, |mut source| async move {
        tokio::task::yield_now().await;
        Ok(source.next().await?.map(|bytes| (bytes, source)))
    })
}

struct Source {
    /// `None` once it has ended.
    stream: Option<BodyDataStream>,
    left: u64,
    budget: ByteBudget,
    pace: Pace,
}

/// The time spent waiting for a body, and the bytes that came, since the last full window.
/// Time in which the reader asks for nothing is not the sender's fault and does not count.
#[derive(Default)]
struct Pace {
    waited: Duration,
    bytes: u64,
}

impl Pace {
    /// The time left in this window.
    fn time_left(&self) -> Duration {
        WINDOW.saturating_sub(self.waited)
    }

    fn note(&mut self, waited: Duration, bytes: u64) {
        self.waited += waited;
        self.bytes += bytes;
        if self.bytes >= WINDOW_BYTES {
            *self = Self::default();
        }
    }
}

impl Source {
    async fn next(&mut self) -> Result<Option<Bytes>, BodyFault> {
        let Some(stream) = &mut self.stream else {
            return Ok(None);
        };
        if self.budget.is_spent() {
            return Err(BodyFault::PartHeaders);
        }
        let start = Instant::now();
        let piece = tokio::time::timeout(self.pace.time_left(), stream.next())
            .await
            .map_err(|_| BodyFault::TooSlow)?;
        let Some(piece) = piece else {
            self.stream = None;
            return Ok(None);
        };
        let piece = piece.map_err(|_| {
            self.stream = None;
            BodyFault::Broken
        })?;
        let length = piece.len() as u64;
        self.pace.note(start.elapsed(), length);
        self.left = self.left.checked_sub(length).ok_or(BodyFault::TooLarge)?;
        self.budget.0.taken.fetch_add(length, Ordering::Relaxed);
        Ok(Some(piece))
    }
}

/// Refuses a body whose Content-Length exceeds `limit`, before any of it is read.
pub fn check_declared(request: Request, limit: u64) -> Result<Request, Error> {
    let declared = request
        .headers()
        .get(CONTENT_LENGTH)
        .and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
    if declared.is_none_or(|length| length <= limit) {
        Ok(request)
    } else {
        Err(BodyFault::TooLarge.refusal(limit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_that_dribbles_runs_out_of_time() {
        let second = Duration::from_secs(1);
        let mut pace = Pace::default();
        for _ in 0..14 {
            pace.note(second, 1000);
        }
        assert_eq!(pace.time_left(), second);
        pace.note(second, 1000);
        assert_eq!(pace.time_left(), Duration::ZERO);

        let mut pace = Pace::default();
        for _ in 0..100 {
            pace.note(second, 1100);
            assert!(pace.time_left() > Duration::ZERO);
        }
    }
}
