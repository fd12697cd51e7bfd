//! JSON documents that came as a body or as a part of one.

use axum::extract::Request;
use futures_util::TryStreamExt;
use serde_json::Value;

use super::body::{self, ByteBudget};
use crate::http::response::error::Error;
use crate::wire::json;

/// Reads a JSON body of at most `limit` bytes.
pub async fn read(request: Request, limit: usize) -> Result<Value, Error> {
    let bytes = read_all(request, limit as u64).await?;
    parse(&bytes, limit)
}

/// Parses a JSON document of at most `limit` bytes that came as a body or as a part of one.
pub fn parse(bytes: &[u8], limit: usize) -> Result<Value, Error> {
    // JSON starts with an ASCII character, so a zero among the first two bytes, or a byte order
    // mark, means UTF-16.
    if let [first, second, ..] = bytes
        && (*first == 0 || *second == 0 || matches!((first, second), (0xfe, 0xff) | (0xff, 0xfe)))
    {
        return Err(Error::unsupported("JSON is read as UTF-8 only"));
    }
    Ok(json::read_up_to(bytes, limit)?)
}

/// Reads a body of at most `limit` bytes.
async fn read_all(request: Request, limit: u64) -> Result<Vec<u8>, Error> {
    let body = body::check_declared(request, limit)?.into_body();
    body::limited(body, limit, ByteBudget::default())
        .try_fold(Vec::new(), |mut all, piece| async move {
            all.extend_from_slice(&piece);
            Ok(all)
        })
        .await
        .map_err(|fault| fault.refusal(limit))
}

/// Runs `work` on a thread that may block: reading or writing megabytes of JSON would keep the other
/// requests of a thread of the runtime waiting.
pub async fn run_blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Error> + Send + 'static,
) -> Result<T, Error> {
    tokio::task::spawn_blocking(work)
        .await
        .map_err(Error::internal)?
}
