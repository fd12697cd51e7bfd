//! The explorer of the API at `/docs/`: Swagger UI, set up and coloured so that everyone can use it.

use axum::Router;
use axum::http::header::CONTENT_TYPE;
use axum::middleware::map_response;
use axum::routing::get;
use utoipa_swagger_ui::SwaggerUi;

use super::policy;

/// Its files, which nobody needs a key for and which ask nothing of any other host.
pub fn files<S: Clone + Send + Sync + 'static>() -> Router<S> {
    let script = || async {
        let kind = [(CONTENT_TYPE, "text/javascript; charset=utf-8")];
        (kind, include_str!("explorer.js"))
    };
    let style = || async {
        let kind = [(CONTENT_TYPE, "text/css; charset=utf-8")];
        (kind, include_str!("explorer.css"))
    };
    // In place of the two files that its page has for that.
    Router::from(SwaggerUi::new("/docs"))
        .route("/docs/swagger-initializer.js", get(script))
        .route("/docs/index.css", get(style))
        .layer(map_response(policy::documentation))
}
