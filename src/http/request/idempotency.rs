//! The header Idempotency-Key: a submission that is sent again is carried out once.

use axum::http::{HeaderMap, HeaderName};

use crate::http::response::error::Error;
use crate::jobs::{IdempotencyKey, Owner, Service};

const IDEMPOTENCY_KEY: HeaderName = HeaderName::from_static("idempotency-key");
const MAX_KEY_CHARS: usize = 255;

/// Begins a submission under the key in its headers; `None` where there is no key.
pub fn begin(
    service: &Service,
    owner: &Owner,
    headers: &HeaderMap,
) -> Result<Option<IdempotencyKey>, Error> {
    let mut lines = headers.get_all(IDEMPOTENCY_KEY).iter();
    let Some(line) = lines.next() else {
        return Ok(None);
    };
    let malformed = || {
        Error::bad_request(
            "the header Idempotency-Key must be one key of 1 to 255 visible ASCII characters, with or without \
             quotation marks around it",
        )
    };
    if lines.next().is_some() {
        return Err(malformed());
    }
    let text = line.to_str().map_err(|_| malformed())?.trim();
    // The draft asks for a quoted string and most clients send the bare key: both mean the same key.
    let key = match text.strip_prefix('"') {
        Some(rest) => rest.strip_suffix('"').ok_or_else(malformed)?,
        None => text,
    };
    let is_allowed = |byte: u8| byte.is_ascii_graphic() && byte != b'"' && byte != b'\\';
    if key.is_empty() || key.len() > MAX_KEY_CHARS || !key.bytes().all(is_allowed) {
        return Err(malformed());
    }
    Ok(Some(service.begin_submission(owner, key)?))
}
