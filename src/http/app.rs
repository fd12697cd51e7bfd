//! The state that all handlers share.

use std::sync::Arc;

use axum::extract::FromRef;
use tower_http::cors::CorsLayer;

use super::layers::auth::AuthLayer;
use super::request::large::LargeBodies;
use crate::jobs::Service;
use crate::wire::PlanRequest;

/// The service behind the routes, and the limits that HTTP puts before it.
#[derive(Clone)]
pub struct App {
    /// Holds meshes, jobs and batches, and evaluates grasps.
    pub service: Service,
    /// The most bytes that an uploaded mesh may have.
    pub max_upload_bytes: u64,
    /// The longest that one job may run, in seconds.
    pub max_job_seconds: f64,
    /// Bounds the large bodies that are in memory at a time.
    pub large_bodies: LargeBodies,
    /// Admits or refuses every request to a route that serves someone's data.
    pub auth: Arc<AuthLayer>,
    /// The other origins whose pages may use the service from a browser.
    pub cors: Option<CorsLayer>,
    /// All routes as the landing page lists them; set by the router.
    pub endpoints: Arc<[String]>,
}

impl FromRef<App> for Service {
    fn from_ref(app: &App) -> Self {
        app.service.clone()
    }
}

impl App {
    /// Shortens the time limit of a request to the longest that the server allows.
    pub fn limit(&self, request: &mut PlanRequest) {
        let asked = request.time_limit_s.unwrap_or(f64::INFINITY);
        request.time_limit_s = Some(asked.min(self.max_job_seconds));
    }
}
