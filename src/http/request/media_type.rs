//! The media type of a body.

use axum::http::header::{CONTENT_ENCODING, CONTENT_TYPE};
use axum::http::{HeaderMap, HeaderValue};

use crate::http::response::error::Error;

/// Returns the Content-Type in lower case and without parameters; `None` when there is none. Refuses
/// with 415 a Content-Encoding and a charset other than UTF-8.
///
/// Not read by a crate such as `mime`: a type that such a crate cannot parse has to reach the caller
/// all the same, who refuses it with the types that are read there.
pub fn of_body(headers: &HeaderMap) -> Result<Option<String>, Error> {
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
