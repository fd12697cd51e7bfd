//! The page: built from `web/` by Vite, and part of a binary that was compiled after that.
//!
//! Its files lie in the binary plain and compressed, so there is nothing here for the compression of
//! tower-http to do.

use axum::Router;
use axum::http::header::{
    ACCEPT_ENCODING, CACHE_CONTROL, CONTENT_ENCODING, CONTENT_SECURITY_POLICY, CONTENT_TYPE, ETAG,
    VARY,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use super::landing;
use crate::http::layers::browser_policy;
use crate::http::request::accept;
use crate::http::request::query::NoQuery;
use crate::http::response::conditional;
use crate::http::response::error::Error;

/// A file of the page.
struct File {
    /// The path that a browser requests, from the slash on.
    path: &'static str,
    /// The hash of its bytes, for the entity tag.
    hash: &'static str,
    bytes: &'static [u8],
    /// The same bytes, compressed.
    gzip: &'static [u8],
}

/// All files of the page; empty in a binary without it.
static FILES: &[File] = include!(concat!(env!("OUT_DIR"), "/page.rs"));

const INDEX: &str = "/index.html";
/// Every name below this path contains the hash of the content.
const HASHED: &str = "/assets/";

/// Returns the page or, in a binary without it, one that says how to get it.
pub fn index(headers: &HeaderMap) -> Response {
    match FILES.iter().find(|file| file.path == INDEX) {
        Some(index) => {
            let mut response = index.answer(headers);
            let policy = browser_policy::page_policy();
            response
                .headers_mut()
                .insert(CONTENT_SECURITY_POLICY, policy);
            response
        }
        None => {
            let kind = HeaderValue::from_static("text/html; charset=utf-8");
            let headers = [
                (CONTENT_TYPE, kind),
                (CONTENT_SECURITY_POLICY, landing::policy()),
            ];
            (headers, landing::HTML).into_response()
        }
    }
}

/// The other files of the page. They need no key.
pub fn files<S: Clone + Send + Sync + 'static>() -> Router<S> {
    let others = FILES.iter().filter(|file| file.path != INDEX);
    others.fold(Router::new(), |router, file| {
        let answer = move |_: NoQuery, headers: HeaderMap| async move {
            Ok::<_, Error>(file.answer(&headers))
        };
        router.route(file.path, get(answer))
    })
}

impl File {
    fn answer(&self, headers: &HeaderMap) -> Response {
        let gzip = accepts_gzip(headers);
        let tag = format!("\"{}{}\"", self.hash, if gzip { "-gzip" } else { "" });
        let mut response = match conditional::has(headers, &tag) {
            true => conditional::not_modified(&tag),
            false => (
                [(CONTENT_TYPE, kind(self.path))],
                if gzip { self.gzip } else { self.bytes },
            )
                .into_response(),
        };
        let mut put = |name: HeaderName, value: &str| {
            if let Ok(value) = HeaderValue::try_from(value) {
                response.headers_mut().insert(name, value);
            }
        };
        put(ETAG, &tag);
        put(VARY, "accept-encoding");
        if gzip {
            put(CONTENT_ENCODING, "gzip");
        }
        if self.path.starts_with(HASHED) {
            put(CACHE_CONTROL, "public, max-age=31536000, immutable");
        }
        response
    }
}

fn accepts_gzip(headers: &HeaderMap) -> bool {
    accept::weighted(headers, &ACCEPT_ENCODING)
        .any(|(coding, weight)| coding == "gzip" && weight > 0.0)
}

fn kind(path: &str) -> &'static str {
    match path.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "svg" => "image/svg+xml",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use axum::http::StatusCode;
    use axum::http::header::IF_NONE_MATCH;

    use super::*;

    const SCRIPT: File = File {
        path: "/assets/page-1a2b.js",
        hash: "0123456789ab",
        bytes: b"plain",
        gzip: b"small",
    };

    async fn body(response: Response) -> Vec<u8> {
        let bytes = axum::body::to_bytes(response.into_body(), 100).await;
        bytes.unwrap().to_vec()
    }

    #[tokio::test]
    async fn who_takes_gzip_gets_it_under_a_tag_of_its_own() {
        let mut tags = Vec::new();
        for (accepted, expected) in [
            ("gzip, deflate, br", b"small"),
            ("br;q=1.0, GZIP;q=0.5", b"small"),
            ("gzip;q=0", b"plain"),
            ("br", b"plain"),
            ("", b"plain"),
        ] {
            let headers = HeaderMap::from_iter([(ACCEPT_ENCODING, accepted.parse().unwrap())]);
            let response = SCRIPT.answer(&headers);
            let coding = response.headers().get(CONTENT_ENCODING);
            assert_eq!(coding.is_some(), expected == b"small", "{accepted}");
            assert_eq!(
                response.headers()[CONTENT_TYPE],
                "text/javascript; charset=utf-8"
            );
            tags.push(response.headers()[ETAG].clone());
            assert_eq!(body(response).await, expected, "{accepted}");
        }
        assert_eq!((&tags[0], &tags[2]), (&tags[1], &tags[3]));
        assert_ne!(tags[0], tags[2]);
        let known = HeaderMap::from_iter([(IF_NONE_MATCH, tags[2].clone())]);
        let unchanged = SCRIPT.answer(&known);
        assert_eq!(unchanged.status(), StatusCode::NOT_MODIFIED);
        assert!(body(unchanged).await.is_empty());
    }

    #[test]
    fn only_what_is_named_by_its_content_is_kept_for_ever() {
        let caching = |path| {
            let file = File { path, ..SCRIPT };
            let response = file.answer(&HeaderMap::new());
            response.headers().get(CACHE_CONTROL).cloned()
        };
        assert!(caching("/assets/page-1a2b.js").is_some());
        assert!(caching("/icon.svg").is_none());
    }
}
