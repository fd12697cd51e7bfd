//! The other origins whose pages may use the service from a browser (CORS).

use std::time::Duration;

use axum::http::header::{
    ACCEPT, AUTHORIZATION, CONTENT_TYPE, ETAG, IF_NONE_MATCH, LOCATION, RETRY_AFTER,
    WWW_AUTHENTICATE,
};
use axum::http::{HeaderName, HeaderValue, Method, Uri};
use tower_http::cors::{Any, CorsLayer};

/// How long a browser may remember a preflight answer.
const MAX_AGE: Duration = Duration::from_secs(3600);

/// Returns the layer that admits `origins`, each `scheme://host[:port]`, or all of them for `*`; `None`
/// for an empty list.
///
/// # Errors
/// Names the origin that cannot be used.
pub fn layer(origins: &[String]) -> Result<Option<CorsLayer>, String> {
    let named = HeaderName::from_static;
    let layer = CorsLayer::new()
        .allow_methods([Method::GET, Method::POST, Method::DELETE])
        .allow_headers([
            ACCEPT,
            AUTHORIZATION,
            CONTENT_TYPE,
            IF_NONE_MATCH,
            named("idempotency-key"),
            named("last-event-id"),
            named("x-request-id"),
        ])
        .expose_headers([
            ETAG,
            LOCATION,
            RETRY_AFTER,
            WWW_AUTHENTICATE,
            named("ratelimit"),
            named("ratelimit-policy"),
            named("x-request-id"),
        ])
        .max_age(MAX_AGE);
    if origins.is_empty() {
        return Ok(None);
    }
    if origins == ["*"] {
        return Ok(Some(layer.allow_origin(Any)));
    }
    let origins: Result<Vec<_>, _> = origins.iter().map(|origin| parse(origin)).collect();
    Ok(Some(layer.allow_origin(origins?)))
}

fn parse(origin: &str) -> Result<HeaderValue, String> {
    let uri: Option<Uri> = origin.parse().ok();
    let is_origin = uri.is_some_and(|uri| {
        let scheme = uri.scheme_str().unwrap_or_default();
        let authority = uri.authority().map_or("", |authority| authority.as_str());
        matches!(scheme, "http" | "https") && origin == format!("{scheme}://{authority}")
    });
    let value = HeaderValue::from_str(origin).ok().filter(|_| is_origin);
    value.ok_or_else(|| {
        format!(
            "--cors-origins: {origin:?} must be scheme://host[:port], or * alone for all origins"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_read_strictly() {
        for good in [
            "https://a.example",
            "http://localhost:5173",
            "http://[::1]:80",
        ] {
            assert!(parse(good).is_ok(), "{good}");
        }
        for bad in [
            "a.example",
            "https://a.example/",
            "ftp://a",
            "*",
            "",
            "https://a b",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
        assert!(layer(&[]).unwrap().is_none());
        assert!(layer(&["*".to_owned()]).unwrap().is_some());
        assert!(layer(&["*".to_owned(), "https://a.example".to_owned()]).is_err());
    }
}
