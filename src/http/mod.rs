//! HTTP: routes, extraction, problem responses, OpenAPI.

mod access;
mod application;
mod batches;
mod body;
mod connections;
mod cors;
mod error;
mod evaluations;
mod events;
mod explorer;
mod exports;
mod form;
mod grasps;
mod jobs;
mod layers;
mod meshes;
mod meter;
mod once;
mod openapi;
mod outcome;
mod page;
mod picture_query;
mod pictures;
mod policy;
mod preview;
mod query;
mod rate;
mod reply;
mod server;
mod socket;
mod system;
mod worker;

pub use application::{Application, wants_keys};
pub use cors::layer as cors_layer;
pub use server::files_needed;
pub use worker::WorkerApplication;

use std::sync::Arc;

use axum::Router;
use axum::extract::FromRef;
use axum::http::StatusCode;
use axum::middleware::{from_fn, from_fn_with_state};
use axum::routing::get;
use tower_http::cors::CorsLayer;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use self::access::Gate;
use self::body::Places;
use self::query::Parameters;
use crate::jobs::Service;
use crate::wire::PlanRequest;

/// What the handlers need.
#[derive(Clone)]
pub struct App {
    /// The one door to meshes and jobs.
    pub service: Service,
    /// Most bytes of an uploaded mesh.
    pub max_upload_bytes: u64,
    /// Longest that one job may run, in seconds.
    pub max_job_seconds: f64,
    /// Of those whose large bodies are held.
    pub large_bodies: Places,
    /// What stands before everything that is someone's.
    pub gate: Arc<Gate>,
    /// Pages of which other origins may use the service.
    pub cors: Option<CorsLayer>,
}

impl FromRef<App> for Service {
    fn from_ref(app: &App) -> Self {
        app.service.clone()
    }
}

impl App {
    /// The request as it will run here: for no longer than the server allows.
    fn limited(&self, mut request: PlanRequest) -> PlanRequest {
        self.limit(&mut request);
        request
    }

    /// As [`App::limited`], in its place.
    fn limit(&self, request: &mut PlanRequest) {
        let wanted = request.time_limit_s.unwrap_or(f64::INFINITY);
        request.time_limit_s = Some(wanted.min(self.max_job_seconds));
    }
}

/// Every route with all that stands before and behind it.
pub fn router(app: App) -> Router {
    let gate = from_fn_with_state(Arc::clone(&app.gate), access::admit);
    let cors = app.cors.clone();
    let (api, description) = routes(|routes| routes.route_layer(gate.clone())).split_for_parts();
    let description = Arc::new(description);
    let describe = move |query: Parameters| {
        let description = Arc::clone(&description);
        async move {
            query.only(&[])?;
            reply::json(StatusCode::OK, &*description)
        }
    };
    let describe = get(describe).route_layer(from_fn(layers::json_accepted));
    let measure = from_fn_with_state(app.service.clone(), meter::measure);
    let router = api
        .with_state(app)
        .route("/openapi.json", describe)
        .merge(page::files())
        .merge(explorer::files());
    let router = layers::wrap(router).layer(measure);
    // Outermost: a browser asks for leave without a key, and reads errors too.
    match cors {
        Some(cors) => router.layer(cors),
        None => router,
    }
}

/// The OpenAPI description as it is kept in the repository.
pub fn openapi_json() -> Result<String, serde_json::Error> {
    let (_, description) = routes(|routes| routes).split_for_parts();
    let mut text = serde_json::to_string_pretty(&description)?;
    text.push('\n');
    Ok(text)
}

/// All routes; `guard` is put before those that lead to what is someone's.
fn routes(guard: impl Fn(OpenApiRouter<App>) -> OpenApiRouter<App>) -> OpenApiRouter<App> {
    let json = OpenApiRouter::new()
        .routes(routes!(jobs::submit, jobs::list))
        .routes(routes!(jobs::read, jobs::delete))
        .routes(routes!(jobs::result))
        .routes(routes!(jobs::cancel))
        .routes(routes!(batches::submit, batches::list))
        .routes(routes!(batches::read, batches::delete))
        .routes(routes!(batches::cancel))
        .routes(routes!(evaluations::evaluate))
        .routes(routes!(meshes::upload, meshes::list))
        .routes(routes!(meshes::read, meshes::delete))
        .route_layer(from_fn(layers::json_accepted));
    let mut guarded = guard(
        json.merge(
            OpenApiRouter::new()
                .routes(routes!(events::events))
                .routes(routes!(batches::results))
                .routes(routes!(meter::metrics))
                .routes(routes!(exports::mesh))
                .routes(routes!(pictures::grasp_png))
                .routes(routes!(pictures::grasp_svg))
                .routes(routes!(pictures::convergence_png))
                .routes(routes!(pictures::convergence_svg))
                .routes(routes!(grasps::glb))
                .routes(routes!(grasps::csv))
                .routes(routes!(grasps::history))
                .routes(routes!(grasps::isaac))
                .routes(routes!(grasps::moveit))
                .routes(routes!(preview::png))
                .routes(routes!(preview::svg)),
        ),
    );
    openapi::describe_guard(guarded.get_openapi_mut());
    let mut all = OpenApiRouter::with_openapi(openapi::description())
        .routes(routes!(system::landing))
        // These answer a probe whatever it accepts.
        .routes(routes!(system::healthz))
        .routes(routes!(system::readyz))
        .merge(guarded);
    openapi::describe_errors(all.get_openapi_mut());
    openapi::forbid_null_parameters(all.get_openapi_mut());
    openapi::show_examples(all.get_openapi_mut());
    all
}
