//! Answers: JSON bodies, files, entity tags, and what a client accepts.

use axum::http::header::{
    ACCEPT, CONTENT_DISPOSITION, CONTENT_TYPE, ETAG, IF_NONE_MATCH, LOCATION,
};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::error::Error;

/// Seconds until a look at an unfinished job is worth another request.
pub const POLL_S: u64 = 1;

/// A JSON body.
pub fn json(status: StatusCode, value: &impl Serialize) -> Result<Response, Error> {
    let body = serde_json::to_vec(value).map_err(Error::internal)?;
    Ok((status, [(CONTENT_TYPE, "application/json")], body).into_response())
}

/// 304 with `tag` when the client has just that.
pub fn not_modified(headers: &HeaderMap, tag: &str) -> Option<Response> {
    has(headers, tag).then(|| (StatusCode::NOT_MODIFIED, [(ETAG, tag)]).into_response())
}

/// A JSON body under an entity tag that is known without its bytes.
pub fn under(tag: &str, value: &impl Serialize) -> Result<Response, Error> {
    let mut response = json(StatusCode::OK, value)?;
    let tag = HeaderValue::try_from(tag).map_err(Error::internal)?;
    response.headers_mut().insert(ETAG, tag);
    Ok(response)
}

/// A JSON body with the hash of its bytes as entity tag; 304 when the client has just that.
pub fn tagged(headers: &HeaderMap, value: &impl Serialize) -> Result<Response, Error> {
    let body = serde_json::to_vec(value).map_err(Error::internal)?;
    let tag = format!("\"{}\"", hash(&body));
    if has(headers, &tag) {
        return Ok((StatusCode::NOT_MODIFIED, [(ETAG, tag)]).into_response());
    }
    let headers = [(ETAG, tag), (CONTENT_TYPE, "application/json".to_owned())];
    Ok((headers, body).into_response())
}

/// A file of some kind with its entity tag and, where it is to be kept, a name.
pub fn file(
    tag: &str,
    kind: &str,
    name: Option<&str>,
    bytes: impl IntoResponse,
) -> Result<Response, Error> {
    let mut response = ([(ETAG, tag), (CONTENT_TYPE, kind)], bytes).into_response();
    if let Some(name) = name {
        let name = format!("attachment; filename=\"{name}\"");
        let name = name.try_into().map_err(Error::internal)?;
        response.headers_mut().insert(CONTENT_DISPOSITION, name);
    }
    Ok(response)
}

/// What tells some bytes from all others in an entity tag.
pub fn hash(bytes: impl AsRef<[u8]>) -> String {
    let hash = Sha256::digest(bytes);
    hash[..16]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Says where the thing is that the answer is about.
pub fn locate(response: &mut Response, path: String) {
    if let Ok(path) = HeaderValue::try_from(path) {
        response.headers_mut().insert(LOCATION, path);
    }
}

/// Whether the client has what `tag` names. If-None-Match compares weakly (RFC 9110, 13.1.2).
pub fn has(headers: &HeaderMap, tag: &str) -> bool {
    let tag = tag.trim_start_matches("W/");
    headers
        .get_all(IF_NONE_MATCH)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .map(|known| known.trim().trim_start_matches("W/"))
        .any(|known| known == tag || known == "*")
}

/// Whether the client takes `kind` (`type/subtype`).
pub fn accepts(headers: &HeaderMap, kind: &str) -> bool {
    weight(headers, kind) > 0.0
}

/// Refuses a client that does not take files of this kind.
pub fn accepted(headers: &HeaderMap, kind: &str) -> Result<(), Error> {
    match accepts(headers, kind) {
        true => Ok(()),
        false => Err(Error::not_acceptable(kind)),
    }
}

/// How much the client wants `kind`, 0 (not at all) to 1. Without an Accept header it takes
/// anything.
///
/// The most specific range that matches decides (RFC 9110, 12.5.1).
pub fn weight(headers: &HeaderMap, kind: &str) -> f32 {
    if !headers.contains_key(ACCEPT) {
        return 1.0;
    }
    let main = kind.split('/').next().unwrap_or_default();
    headers
        .get_all(ACCEPT)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .filter_map(|range| {
            let mut pieces = range.split(';').map(str::trim);
            let name = pieces.next()?.to_ascii_lowercase();
            let specific = match name.as_str() {
                "*/*" => 0,
                name if name.strip_suffix("/*") == Some(main) => 1,
                name if name == kind => 2,
                _ => return None,
            };
            let weight = pieces
                .filter_map(|piece| piece.split_once('='))
                .find(|(name, _)| name.eq_ignore_ascii_case("q"))
                .and_then(|(_, weight)| weight.parse().ok());
            Some((specific, weight.unwrap_or(1.0)))
        })
        .max_by_key(|(specific, _)| *specific)
        .map_or(0.0, |(_, weight)| weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(accept: &str) -> HeaderMap {
        HeaderMap::from_iter([(ACCEPT, accept.parse().unwrap())])
    }

    #[test]
    fn the_most_specific_range_decides() {
        let json = "application/json";
        assert!(accepts(&HeaderMap::new(), json));
        for good in [
            "*/*",
            "application/*",
            "text/html, application/json;q=0.1",
            "Application/JSON",
        ] {
            assert!(accepts(&with(good), json), "{good}");
        }
        for bad in [
            "text/html",
            "application/json;q=0, */*",
            "application/json;Q=0.0",
            "",
            "applicationx/*",
        ] {
            assert!(!accepts(&with(bad), json), "{bad}");
        }
    }
}
