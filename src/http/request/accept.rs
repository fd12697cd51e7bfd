//! What a client accepts: the headers Accept and Accept-Encoding (RFC 9110, 12.5).
//!
//! Not read by a crate such as `headers-accept`: that one rejects the whole header for one malformed
//! range, and returns the best of the offered types but not their weights, which the choice between
//! the page and JSON compares.

use axum::http::header::ACCEPT;
use axum::http::{HeaderMap, HeaderName};

use crate::http::response::error::Error;

/// Whether the client accepts `media_type` (`type/subtype`).
pub fn accepts(headers: &HeaderMap, media_type: &str) -> bool {
    weight(headers, media_type) > 0.0
}

/// Refuses with 406 a client that does not accept `media_type`.
pub fn require(headers: &HeaderMap, media_type: &str) -> Result<(), Error> {
    match accepts(headers, media_type) {
        true => Ok(()),
        false => Err(Error::not_acceptable(media_type)),
    }
}

/// Returns the weight that the client gives to `media_type`, from 0 (not acceptable) to 1. A client
/// without an Accept header accepts anything.
///
/// The most specific range that matches decides (RFC 9110, 12.5.1).
pub fn weight(headers: &HeaderMap, media_type: &str) -> f32 {
    if !headers.contains_key(ACCEPT) {
        return 1.0;
    }
    let main = media_type.split('/').next().unwrap_or_default();
    weighted(headers, &ACCEPT)
        .filter_map(|(range, weight)| {
            let specificity = match range.as_str() {
                "*/*" => 0,
                range if range.strip_suffix("/*") == Some(main) => 1,
                range if range == media_type => 2,
                _ => return None,
            };
            Some((specificity, weight))
        })
        .max_by_key(|(specificity, _)| *specificity)
        .map_or(0.0, |(_, weight)| weight)
}

/// Returns the items of a header such as `gzip;q=0.5, br`, in lower case, each with its weight.
pub fn weighted(headers: &HeaderMap, name: &HeaderName) -> impl Iterator<Item = (String, f32)> {
    headers
        .get_all(name)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .map(|item| {
            let mut pieces = item.split(';').map(str::trim);
            let item = pieces.next().unwrap_or_default().to_ascii_lowercase();
            let weight = pieces
                .filter_map(|piece| piece.split_once('='))
                .find(|(name, _)| name.eq_ignore_ascii_case("q"))
                .and_then(|(_, weight)| weight.parse().ok());
            (item, weight.unwrap_or(1.0))
        })
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
