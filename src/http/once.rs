//! The header Idempotency-Key.

use axum::http::{HeaderMap, HeaderName};

use super::error::Error;
use crate::jobs::{IdempotencyKey, Owner, Service};

const IDEMPOTENCY_KEY: HeaderName = HeaderName::from_static("idempotency-key");
const MAX_KEY_CHARS: usize = 255;

/// Begins a submission under the key that its headers name, if they name one.
pub fn begin(
    service: &Service,
    owner: &Owner,
    headers: &HeaderMap,
) -> Result<Option<IdempotencyKey>, Error> {
    let mut lines = headers.get_all(IDEMPOTENCY_KEY).iter();
    let Some(line) = lines.next() else {
        return Ok(None);
    };
    let wanted = || {
        Error::bad_request(
            "the header Idempotency-Key holds one key of 1 to 255 visible ASCII characters, with or without \
             quotation marks around it",
        )
    };
    if lines.next().is_some() {
        return Err(wanted());
    }
    let text = line.to_str().map_err(|_| wanted())?.trim();
    // The draft has a quoted string, most clients send the bare key: they are the same.
    let key = match text.strip_prefix('"') {
        Some(rest) => rest.strip_suffix('"').ok_or_else(wanted)?,
        None => text,
    };
    let is_fit = |byte: u8| byte.is_ascii_graphic() && byte != b'"' && byte != b'\\';
    if key.is_empty() || key.len() > MAX_KEY_CHARS || !key.bytes().all(is_fit) {
        return Err(wanted());
    }
    Ok(Some(service.begin_submission(owner, key)?))
}
