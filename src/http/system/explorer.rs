//! The API explorer at `/docs/`: Swagger UI, with a script and a style of this repository that make it accessible.

use axum::Router;
use axum::http::header::CONTENT_TYPE;
use axum::middleware::map_response;
use axum::routing::get;
use utoipa_swagger_ui::SwaggerUi;

use crate::http::layers::browser_policy;

/// The files of the explorer. They need no key and load nothing from any other host.
pub fn files<S: Clone + Send + Sync + 'static>() -> Router<S> {
    let script = || async {
        let kind = [(CONTENT_TYPE, "text/javascript; charset=utf-8")];
        (kind, include_str!("explorer.js"))
    };
    let style = || async {
        let kind = [(CONTENT_TYPE, "text/css; charset=utf-8")];
        (kind, include_str!("explorer.css"))
    };
    // These two replace the files of the same names in Swagger UI.
    Router::from(SwaggerUi::new("/docs"))
        .route("/docs/swagger-initializer.js", get(script))
        .route("/docs/index.css", get(style))
        .layer(map_response(browser_policy::set_explorer_policy))
}
