//! All routes, with the layers around them.

use std::sync::Arc;

use axum::Router;
use axum::http::StatusCode;
use axum::middleware::{from_fn, from_fn_with_state};
use axum::routing::get;
use utoipa::openapi::OpenApi;
use utoipa_axum::router::{OpenApiRouter, UtoipaMethodRouter};
use utoipa_axum::routes;

use super::app::App;
use super::layers::{self, accept_json, auth, request_metrics};
use super::openapi::rules::{self, Access};
use super::request::query::NoQuery;
use super::response::json;
use super::system::{explorer, metrics, page, status};
use super::{batches, evaluations, exports, jobs, meshes, openapi};

/// Returns every route behind all layers; the head of [`crate::http`] says what a request passes.
pub fn router(mut app: App) -> Router {
    let authenticate = from_fn_with_state(Arc::clone(&app.auth), auth::authenticate);
    let measure = from_fn_with_state(app.service.clone(), request_metrics::measure);
    let cors = app.cors.clone();

    let routes = Routes::all();
    app.endpoints = routes.endpoints();
    let (api, document) = routes.into_router(|guarded| guarded.route_layer(authenticate));
    let document = Arc::new(document);
    let openapi_json = get(async move |_: NoQuery| json::json(StatusCode::OK, &*document));
    let router = api
        .with_state(app)
        .route(
            "/openapi.json",
            openapi_json.route_layer(from_fn(accept_json::check)),
        )
        .merge(page::files())
        .merge(explorer::files());
    let router = layers::wrap(router).layer(measure);
    // Outermost: a browser sends its preflight requests without a key, and reads errors too.
    match cors {
        Some(cors) => router.layer(cors),
        None => router,
    }
}

/// Returns the OpenAPI document as the repository keeps it.
pub fn openapi_json() -> Result<String, serde_json::Error> {
    let (_, document) = Routes::all().into_router(|guarded| guarded);
    let mut text = serde_json::to_string_pretty(&document)?;
    text.push('\n');
    Ok(text)
}

/// The routes, by the layers in front of them, in the order in which the landing page lists them.
struct Routes {
    /// Answers anyone, whatever they accept.
    public: OpenApiRouter<App>,
    /// Answers in JSON, for a caller who is authenticated.
    json: OpenApiRouter<App>,
    /// Answers in other formats, and checks itself whether the client accepts them.
    other: OpenApiRouter<App>,
    listed: Vec<String>,
}

impl Routes {
    fn all() -> Self {
        let (of_jobs, of_meshes): (Vec<_>, Vec<_>) =
            exports::routes().partition(|route| names(route)[0].starts_with("GET /jobs"));
        let mut routes = Self {
            public: OpenApiRouter::with_openapi(openapi::document())
                .routes(routes!(status::landing)),
            json: OpenApiRouter::new(),
            other: OpenApiRouter::new(),
            listed: Vec::new(),
        };
        routes.json(routes!(jobs::submit::submit_job));
        routes.json(routes!(jobs::read::list_jobs));
        routes.json(routes!(jobs::read::read_job));
        routes.json(routes!(jobs::read::read_result));
        routes.other(routes!(jobs::events::follow_job));
        routes.json(routes!(jobs::change::cancel_job));
        routes.json(routes!(jobs::change::delete_job));
        for export in of_jobs {
            routes.other(export);
        }
        routes.json(routes!(batches::submit::submit_batch));
        routes.json(routes!(batches::read::list_batches));
        routes.json(routes!(batches::read::read_batch));
        routes.other(routes!(batches::results::read_batch_results));
        routes.json(routes!(batches::change::cancel_batch));
        routes.json(routes!(batches::change::delete_batch));
        routes.json(routes!(evaluations::evaluate));
        routes.json(routes!(meshes::upload::upload_mesh));
        routes.json(routes!(meshes::records::list_meshes));
        routes.json(routes!(meshes::records::read_mesh));
        routes.other(routes!(meshes::file::export_mesh));
        for export in of_meshes {
            routes.other(export);
        }
        routes.json(routes!(meshes::records::delete_mesh));
        routes.listed.push("GET /docs".to_owned());
        routes.listed.push("GET /openapi.json".to_owned());
        routes.public(routes!(status::healthz));
        routes.public(routes!(status::readyz));
        routes.other(routes!(metrics::metrics));
        routes
    }

    fn public(&mut self, route: UtoipaMethodRouter<App>) {
        self.listed.extend(names(&route));
        self.public = std::mem::take(&mut self.public).routes(route);
    }

    fn json(&mut self, route: UtoipaMethodRouter<App>) {
        self.listed.extend(names(&route));
        self.json = std::mem::take(&mut self.json).routes(route);
    }

    fn other(&mut self, route: UtoipaMethodRouter<App>) {
        self.listed.extend(names(&route));
        self.other = std::mem::take(&mut self.other).routes(route);
    }

    /// Returns all routes, each as its method and path.
    fn endpoints(&self) -> Arc<[String]> {
        self.listed.clone().into()
    }

    /// Puts all routes together, those that need authentication behind `guard`, with the finished
    /// document.
    fn into_router(
        self,
        guard: impl FnOnce(OpenApiRouter<App>) -> OpenApiRouter<App>,
    ) -> (Router<App>, OpenApi) {
        let json = self.json.route_layer(from_fn(accept_json::check));
        let mut guarded = guard(json.merge(self.other));
        rules::complete(guarded.get_openapi_mut(), Access::Guarded);
        let mut public = self.public;
        rules::complete(public.get_openapi_mut(), Access::Public);
        let mut all = public.merge(guarded);
        openapi::finish(all.get_openapi_mut());
        all.split_for_parts()
    }
}

/// Returns the methods and paths of a route, such as `GET /jobs`.
fn names((_, paths, _): &UtoipaMethodRouter<App>) -> Vec<String> {
    let paths = paths.paths.iter();
    paths
        .flat_map(|(path, item)| {
            [
                ("GET", item.get.is_some()),
                ("POST", item.post.is_some()),
                ("DELETE", item.delete.is_some()),
            ]
            .into_iter()
            .filter(|(_, is_served)| *is_served)
            .map(move |(method, _)| format!("{method} {path}"))
        })
        .collect()
}
