//! What a browser may do with an answer: headers of every one, and the content security policies
//! of the pages.

use std::sync::LazyLock;

use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
    X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use axum::response::Response;
use base64::prelude::{BASE64_STANDARD, Engine};
use sha2::{Digest, Sha256};

/// A policy that allows these sources and nothing else. What `default-src` does not stand for is shut by name.
macro_rules! shut {
    ($sources:literal) => {
        HeaderValue::from_static(concat!(
            "default-src 'none'; ",
            $sources,
            "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        ))
    };
}

/// Headers of every answer whatever it is.
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

/// Adds what is missing of the headers that say what a browser may do.
pub async fn secure(mut response: Response) -> Response {
    let headers = response.headers_mut();
    headers.extend(ALWAYS.iter().cloned());
    let policy = of_kind(headers);
    headers
        .entry(CACHE_CONTROL)
        .or_insert(HeaderValue::from_static("no-cache"));
    headers.entry(CONTENT_SECURITY_POLICY).or_insert(policy);
    response
}

/// The policy of an answer that has none of its own.
fn of_kind(headers: &HeaderMap) -> HeaderValue {
    match headers.get(CONTENT_TYPE) {
        // Such a picture has its style and its pixels inside, and may be opened as a page.
        Some(kind) if kind == "image/svg+xml" => {
            shut!("style-src 'unsafe-inline'; img-src data:; ")
        }
        _ => shut!(""),
    }
}

/// Gives the pages of the documentation their policy: scripts, styles and calls of this origin, and pictures
/// that a call has brought.
pub async fn documentation(mut response: Response) -> Response {
    let policy = shut!(
        "script-src 'self'; img-src 'self' data: blob:; connect-src 'self'; style-src 'self'; "
    );
    let headers = response.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, policy);
    response
}

/// The policy of the page: what it consists of and what it calls is of this origin; pictures that it was sent
/// under a key it shows from memory.
pub fn page() -> HeaderValue {
    shut!("script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; ")
}

/// What stands in for the page where it was not built.
pub const LANDING: &str = include_str!("landing.html");

/// The policy of the landing page: its one style, known by its hash, and nothing else.
pub fn landing() -> HeaderValue {
    static POLICY: LazyLock<HeaderValue> = LazyLock::new(|| {
        let style = LANDING
            .split_once("<style>")
            .and_then(|(_, rest)| rest.split_once("</style>"))
            .map_or("", |(style, _)| style);
        let hash = BASE64_STANDARD.encode(Sha256::digest(style));
        let policy = format!(
            "default-src 'none'; style-src 'sha256-{hash}'; img-src data:; base-uri 'none'; form-action 'none'; \
             frame-ancestors 'none'"
        );
        HeaderValue::try_from(policy).unwrap_or_else(|_| shut!(""))
    });
    POLICY.clone()
}
