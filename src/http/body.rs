//! Request bodies: read as a stream, never longer nor slower than allowed.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll, ready};
use std::time::{Duration, Instant};

use axum::body::{Body, BodyDataStream, Bytes, HttpBody};
use axum::extract::Request;
use axum::http::header::{CONTENT_ENCODING, CONTENT_LENGTH, CONTENT_TYPE, EXPECT};
use axum::http::{HeaderMap, HeaderValue};
use futures_util::{Stream, StreamExt, TryStreamExt, pin_mut, stream};
use serde_json::Value;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::error::Error;
use crate::wire::json;

/// Longest that is waited for the next [`WINDOW_BYTES`] of a body, or for its end: 1 KiB/s.
const WINDOW: Duration = Duration::from_secs(15);
const WINDOW_BYTES: u64 = 15 * 1024;

/// What of an unread body is still taken in after an early answer, so that a client which is
/// still sending gets to read that answer instead of a reset connection.
const DRAIN_BYTES: u64 = 256 << 20;
const DRAIN_TIME: Duration = Duration::from_secs(15);

/// Why a body could not be read to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// Longer than the limit.
    #[error("body too large")]
    TooLarge,
    /// Fewer than [`WINDOW_BYTES`] in [`WINDOW`].
    #[error("body too slow")]
    TooSlow,
    /// The connection ended before the body did, or its framing is broken.
    #[error("body broken")]
    Broken,
    /// The headers of one part of a form pass the budget set with [`Meter::expect_within`].
    #[error("part headers too large")]
    PartHeaders,
}

impl Fault {
    /// The fault at the bottom of an error that travelled through other libraries.
    pub fn beneath(error: &(dyn std::error::Error + 'static)) -> Option<Self> {
        let mut link = Some(error);
        while let Some(error) = link {
            if let Some(fault) = error.downcast_ref::<Self>() {
                return Some(*fault);
            }
            link = error.source();
        }
        None
    }

    /// The answer, with `limit` the most bytes that were allowed.
    pub fn refuse(self, limit: u64) -> Error {
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

/// Counts what a reader takes from a body, so that it can be told to find something soon.
#[derive(Clone, Default)]
pub struct Meter(Arc<Counts>);

#[derive(Default)]
struct Counts {
    taken: AtomicU64,
    /// Value of `taken` from which on no more is given; 0 is none.
    stop: AtomicU64,
}

impl Meter {
    /// The reader must not ask for more once it has taken `bytes` from here on.
    pub fn expect_within(&self, bytes: u64) {
        let taken = self.0.taken.load(Ordering::Relaxed);
        self.0.stop.store(taken + bytes, Ordering::Relaxed);
    }

    /// No budget from here on.
    pub fn relax(&self) {
        self.0.stop.store(0, Ordering::Relaxed);
    }

    fn spent(&self) -> bool {
        let stop = self.0.stop.load(Ordering::Relaxed);
        stop != 0 && self.0.taken.load(Ordering::Relaxed) >= stop
    }
}

/// The body as a stream that fails beyond `limit` bytes and when it comes too slowly.
///
/// It gives way after every piece: a reader that takes whatever is ready would otherwise hold
/// all that a fast client sends.
pub fn metered(
    body: Body,
    limit: u64,
    meter: Meter,
) -> impl Stream<Item = Result<Bytes, Fault>> + Send + 'static {
    let source = Source {
        stream: Some(body.into_data_stream()),
        left: limit,
        meter,
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
    meter: Meter,
    pace: Pace,
}

/// How long a body was waited for, and how much of it came, since it last came fast enough.
/// Time in which nobody asks for more is not the sender's fault and does not count.
#[derive(Default)]
struct Pace {
    waited: Duration,
    bytes: u64,
}

impl Pace {
    /// How much longer it may be waited for.
    fn patience(&self) -> Duration {
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
    async fn next(&mut self) -> Result<Option<Bytes>, Fault> {
        let Some(stream) = &mut self.stream else {
            return Ok(None);
        };
        if self.meter.spent() {
            return Err(Fault::PartHeaders);
        }
        let start = Instant::now();
        let piece = tokio::time::timeout(self.pace.patience(), stream.next())
            .await
            .map_err(|_| Fault::TooSlow)?;
        let Some(piece) = piece else {
            self.stream = None;
            return Ok(None);
        };
        let piece = piece.map_err(|_| {
            self.stream = None;
            Fault::Broken
        })?;
        let length = piece.len() as u64;
        self.pace.note(start.elapsed(), length);
        self.left = self.left.checked_sub(length).ok_or(Fault::TooLarge)?;
        self.meter.0.taken.fetch_add(length, Ordering::Relaxed);
        Ok(Some(piece))
    }
}

/// Lets a client that is still sending when it is answered finish, whoever answers and however
/// much of the body was read.
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
    /// Whether its sender still waits for leave to send; to ask for more would give it.
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

/// Refuses a body that says itself that it is too long, before any of it is read.
pub fn check_declared(request: Request, limit: u64) -> Result<Request, Error> {
    let declared = request
        .headers()
        .get(CONTENT_LENGTH)
        .and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
    if declared.is_none_or(|length| length <= limit) {
        Ok(request)
    } else {
        Err(Fault::TooLarge.refuse(limit))
    }
}

/// Reads a JSON body of at most `limit` bytes.
pub async fn read_json(request: Request, limit: usize) -> Result<Value, Error> {
    let bytes = read_all(request, limit as u64).await?;
    parse_json(&bytes, limit)
}

/// Parses a JSON document of at most `limit` bytes that came as a body or as a part of one.
pub fn parse_json(bytes: &[u8], limit: usize) -> Result<Value, Error> {
    // JSON starts with an ASCII character, so a zero among the first two bytes, or a byte order
    // mark, is UTF-16.
    if let [first, second, ..] = bytes
        && (*first == 0 || *second == 0 || matches!((first, second), (0xfe, 0xff) | (0xff, 0xfe)))
    {
        return Err(Error::unsupported("JSON is read as UTF-8 only"));
    }
    Ok(json::read_up_to(bytes, limit)?)
}

/// Reads a body of at most `limit` bytes.
async fn read_all(request: Request, limit: u64) -> Result<Vec<u8>, Error> {
    let body = check_declared(request, limit)?.into_body();
    metered(body, limit, Meter::default())
        .try_fold(Vec::new(), |mut all, piece| async move {
            all.extend_from_slice(&piece);
            Ok(all)
        })
        .await
        .map_err(|fault| fault.refuse(limit))
}

/// Bodies of at most so many bytes are held without counting them.
pub const LARGE_BYTES: usize = 64 * 1024;
/// Larger ones that are held at a time: with up to 8 MiB each, and several times that once parsed.
const LARGE_BODIES: usize = 16;

/// The places of those whose large bodies are held.
pub type Places = Arc<Semaphore>;
/// One of them.
pub type Place = OwnedSemaphorePermit;

/// A body that may be large.
pub struct Large {
    pub bytes: Vec<u8>,
    /// To be kept while the bytes and what was made of them are.
    pub place: Option<Place>,
}

/// All places, free.
pub fn places() -> Places {
    Arc::new(Semaphore::new(LARGE_BODIES))
}

/// A place among those whose large bodies are held.
pub fn place(places: &Places) -> Result<Place, Error> {
    Arc::clone(places).try_acquire_owned().map_err(|_| {
        Error::unavailable(
            "too-many-large-bodies",
            "too many large requests are being read; send it again in a moment",
            1,
        )
    })
}

/// Reads a body of at most `limit` bytes, one of a few large ones at a time.
pub async fn read_large(places: &Places, request: Request, limit: u64) -> Result<Large, Error> {
    let body = check_declared(request, limit)?.into_body();
    let pieces = metered(body, limit, Meter::default());
    pin_mut!(pieces);
    let mut large = Large {
        bytes: Vec::new(),
        place: None,
    };
    while let Some(piece) = pieces.next().await {
        large
            .bytes
            .extend_from_slice(&piece.map_err(|fault| fault.refuse(limit))?);
        if large.bytes.len() > LARGE_BYTES && large.place.is_none() {
            large.place = Some(place(places)?);
        }
    }
    Ok(large)
}

/// Works on megabytes of JSON, which takes too long for a thread that other clients wait for.
pub async fn apart<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> Result<T, Error> {
    tokio::task::spawn_blocking(work)
        .await
        .map_err(Error::internal)?
}

/// The kind of a body: type and subtype in lower case, without parameters; `None` when it does
/// not say. Refuses with 415 a Content-Encoding and a text encoding other than UTF-8.
pub fn media_type(headers: &HeaderMap) -> Result<Option<String>, Error> {
    let encoded = |value: &HeaderValue| !value.as_bytes().eq_ignore_ascii_case(b"identity");
    if headers.get_all(CONTENT_ENCODING).iter().any(encoded) {
        return Err(Error::unsupported(
            "encoded bodies are not read; send it without Content-Encoding",
        ));
    }
    if headers.get_all(CONTENT_TYPE).iter().count() > 1 {
        return Err(Error::unsupported("a body has one Content-Type"));
    }
    let Some(value) = headers
        .get(CONTENT_TYPE)
        .and_then(|value| value.to_str().ok())
    else {
        return Ok(None);
    };
    let mut pieces = value.split(';').map(str::trim);
    let essence = pieces.next().unwrap_or_default().to_ascii_lowercase();
    let charset = pieces
        .filter_map(|piece| piece.split_once('='))
        .find(|(name, _)| name.eq_ignore_ascii_case("charset"))
        .map(|(_, value)| value.trim_matches('"').to_ascii_lowercase());
    match charset.as_deref() {
        None | Some("utf-8" | "us-ascii") => Ok(Some(essence)),
        Some(_) => Err(Error::unsupported("text is read as UTF-8 only")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_that_dribbles_runs_out_of_patience() {
        let second = Duration::from_secs(1);
        let mut pace = Pace::default();
        for _ in 0..14 {
            pace.note(second, 1000);
        }
        assert_eq!(pace.patience(), second);
        pace.note(second, 1000);
        assert_eq!(pace.patience(), Duration::ZERO);

        let mut pace = Pace::default();
        for _ in 0..100 {
            pace.note(second, 1100);
            assert!(pace.patience() > Duration::ZERO);
        }
    }
}
