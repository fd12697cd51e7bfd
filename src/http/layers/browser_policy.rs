//! The rules for browsers: headers of every response, and the content security policies
//! of the pages.

use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
    X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use axum::response::Response;

/// A policy that allows the given sources and nothing else. Directives that do not fall back to
/// `default-src` are closed by name.
macro_rules! allow_only {
    ($sources:literal) => {
        HeaderValue::from_static(concat!(
            "default-src 'none'; ",
            $sources,
            "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        ))
    };
}

/// The headers of every response.
static ALWAYS: [(HeaderName, HeaderValue); 6] = [
    (X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff")),
    (X_FRAME_OPTIONS, HeaderValue::from_static("DENY")),
    (REFERRER_POLICY, HeaderValue::from_static("no-referrer")),
    (
        HeaderName::from_static("cross-origin-opener-policy"),
        HeaderValue::from_static("same-origin"),
    ),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        HeaderValue::from_static("same-origin"),
    ),
    (
        HeaderName::from_static("permissions-policy"),
        HeaderValue::from_static(
            "camera=(), display-capture=(), geolocation=(), microphone=(), payment=(), usb=()",
        ),
    ),
];

/// Adds the headers that say what a browser may do; caching and policy only where a handler has not
/// set them itself.
pub async fn add_headers(mut response: Response) -> Response {
    let headers = response.headers_mut();
    headers.extend(ALWAYS.iter().cloned());
    let policy = policy_for(headers);
    headers
        .entry(CACHE_CONTROL)
        .or_insert(HeaderValue::from_static("no-cache"));
    headers.entry(CONTENT_SECURITY_POLICY).or_insert(policy);
    response
}

/// The policy of a response whose handler set none.
fn policy_for(headers: &HeaderMap) -> HeaderValue {
    match headers.get(CONTENT_TYPE) {
        // An SVG has its style and its pixels inside, and may be opened as a page.
        Some(kind) if kind == "image/svg+xml" => {
            allow_only!("style-src 'unsafe-inline'; img-src data:; ")
        }
        _ => allow_only!(""),
    }
}

/// Sets the policy of the API explorer: scripts, styles and calls of this origin, and the pictures
/// that a call returned.
pub async fn set_explorer_policy(mut response: Response) -> Response {
    let policy = allow_only!(
        "script-src 'self'; img-src 'self' data: blob:; connect-src 'self'; style-src 'self'; "
    );
    let headers = response.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, policy);
    response
}

/// The policy of the page: it loads from and calls this origin alone; pictures that it fetched with a
/// key are shown from memory (`blob:`).
pub fn page_policy() -> HeaderValue {
    allow_only!("script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; ")
}
