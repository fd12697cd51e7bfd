//! The policy headers for browsers; tests/browser.sh tests them in one.

use reqwest::header::HeaderMap;

use crate::common::{Server, server, small_box};

async fn headers(server: &Server, path: &str, accept: &str) -> HeaderMap {
    let request = server.get(path).header("accept", accept);
    request.send().await.expect("an answer").headers().clone()
}

fn policy(headers: &HeaderMap) -> &str {
    headers["content-security-policy"].to_str().expect("text")
}

#[tokio::test(flavor = "multi_thread")]
async fn pages_run_nothing_but_what_they_bring_and_data_runs_nothing() {
    let server = server().await;
    let mesh = server.mesh(small_box()).await;
    let picture = format!("/meshes/{mesh}/preview.svg");
    for (path, accept) in [
        ("/", "text/html"),
        ("/docs/", "text/html"),
        ("/docs/swagger-ui-bundle.js", "*/*"),
        ("/jobs", "*/*"),
        ("/nowhere", "*/*"),
        ("/openapi.json", "*/*"),
        (picture.as_str(), "*/*"),
    ] {
        let headers = headers(&server, path, accept).await;
        let policy = policy(&headers);
        assert!(
            policy.starts_with("default-src 'none'; "),
            "{path}: {policy}"
        );
        for part in [
            "frame-ancestors 'none'",
            "base-uri 'none'",
            "form-action 'none'",
        ] {
            assert!(policy.contains(part), "{path}: {policy}");
        }
        assert!(
            !policy.contains("unsafe-eval") && !policy.contains("http"),
            "{path}: {policy}"
        );
        // A picture has its style inside and runs no script.
        assert_eq!(
            policy.contains("unsafe-inline"),
            path == picture,
            "{path}: {policy}"
        );
        // What stands in for the page, where it was not built, runs none.
        let runs = policy.contains("script-src");
        assert!(
            runs == path.starts_with("/docs") || path == "/",
            "{path}: {policy}"
        );
        assert!(
            !runs || policy.contains("script-src 'self'; "),
            "{path}: {policy}"
        );
        for name in ["cross-origin-opener-policy", "cross-origin-resource-policy"] {
            assert_eq!(headers[name], "same-origin", "{path}");
        }
        assert!(headers.contains_key("permissions-policy"), "{path}");
    }
}
