//! Conditional responses: what the client has already, as its If-None-Match says, is answered with
//! 304 instead of being made or sent again (RFC 9110, 13.1.2).

use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE, ETAG, IF_NONE_MATCH};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::error::Error;
use super::json::json;

/// The properties of a file that are known before it is written.
pub struct FileHead {
    /// The entity tag, which names these bytes.
    pub tag: String,
    pub media_type: &'static str,
    /// The name to save it under; without one it is shown.
    pub name: Option<String>,
}

/// Answers with a file: 304 when the client has it, else what `write` returns. Nothing is written for
/// a client that has the file.
pub async fn file<B: IntoResponse>(
    headers: &HeaderMap,
    head: FileHead,
    write: impl Future<Output = Result<B, Error>>,
) -> Result<Response, Error> {
    let FileHead {
        tag,
        media_type,
        name,
    } = head;
    if has(headers, &tag) {
        return Ok(not_modified(&tag));
    }
    let bytes = write.await?;
    let mut response = ([(ETAG, tag.as_str()), (CONTENT_TYPE, media_type)], bytes).into_response();
    if let Some(name) = name {
        let disposition = format!("attachment; filename=\"{name}\"");
        let disposition = disposition.try_into().map_err(Error::internal)?;
        response
            .headers_mut()
            .insert(CONTENT_DISPOSITION, disposition);
    }
    Ok(response)
}

/// Answers with JSON whose entity tag is known before its bytes; 304 when the client has it.
pub fn tagged_json(
    headers: &HeaderMap,
    tag: &str,
    value: &impl Serialize,
) -> Result<Response, Error> {
    if has(headers, tag) {
        return Ok(not_modified(tag));
    }
    let mut response = json(StatusCode::OK, value)?;
    let tag = HeaderValue::try_from(tag).map_err(Error::internal)?;
    response.headers_mut().insert(ETAG, tag);
    Ok(response)
}

/// Answers with JSON whose entity tag is the hash of its bytes; 304 when the client has it.
pub fn hashed_json(headers: &HeaderMap, value: &impl Serialize) -> Result<Response, Error> {
    let body = serde_json::to_vec(value).map_err(Error::internal)?;
    let tag = format!("\"{}\"", hash(&body));
    if has(headers, &tag) {
        return Ok(not_modified(&tag));
    }
    let headers = [(ETAG, tag), (CONTENT_TYPE, "application/json".to_owned())];
    Ok((headers, body).into_response())
}

/// Returns 304 with `tag`.
pub fn not_modified(tag: &str) -> Response {
    (StatusCode::NOT_MODIFIED, [(ETAG, tag)]).into_response()
}

/// Whether the client has what `tag` names. Tags are compared weakly, as If-None-Match asks for; those
/// of this service have no commas inside, so the list is split at commas.
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

/// Returns 32 hexadecimal digits that stand for some bytes in an entity tag.
pub fn hash(bytes: impl AsRef<[u8]>) -> String {
    let hash = Sha256::digest(bytes);
    hash[..16]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}
