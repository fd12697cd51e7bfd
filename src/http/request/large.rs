//! Bodies of megabytes, of which only a few are in memory at a time.

use std::sync::Arc;

use axum::extract::Request;
use futures_util::{StreamExt, pin_mut};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::body::{self, ByteBudget};
use crate::http::response::error::Error;

/// Bodies of at most this many bytes need no permit.
pub const LARGE_BYTES: usize = 64 * 1024;
/// The most large bodies in memory at a time. Each may have 8 MiB, and several times that once parsed.
const LARGE_BODIES: usize = 16;

/// Bounds the large bodies that are in memory at a time.
#[derive(Clone)]
pub struct LargeBodies(Arc<Semaphore>);

/// Held while a large body, or what was parsed from it, is in memory.
pub type LargeBodyPermit = OwnedSemaphorePermit;

/// A body that may be large.
pub struct LargeBody {
    pub bytes: Vec<u8>,
    /// To be kept as long as the bytes or what was made of them; `None` for a small body.
    pub permit: Option<LargeBodyPermit>,
}

impl Default for LargeBodies {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(LARGE_BODIES)))
    }
}

impl LargeBodies {
    /// Admits one more large body, or refuses it with 503.
    pub fn admit(&self) -> Result<LargeBodyPermit, Error> {
        Arc::clone(&self.0).try_acquire_owned().map_err(|_| {
            Error::unavailable(
                "too-many-large-bodies",
                "too many large requests are being read; send it again in a moment",
                1,
            )
        })
    }

    /// Reads a body of at most `limit` bytes, with a permit from the moment it is large.
    pub async fn read(&self, request: Request, limit: u64) -> Result<LargeBody, Error> {
        let body = body::check_declared(request, limit)?.into_body();
        let pieces = body::limited(body, limit, ByteBudget::default());
        pin_mut!(pieces);
        let mut large = LargeBody {
            bytes: Vec::new(),
            permit: None,
        };
        while let Some(piece) = pieces.next().await {
            let piece = piece.map_err(|fault| fault.refusal(limit))?;
            large.bytes.extend_from_slice(&piece);
            if large.bytes.len() > LARGE_BYTES && large.permit.is_none() {
                large.permit = Some(self.admit()?);
            }
        }
        Ok(large)
    }
}
