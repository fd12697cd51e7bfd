//! Metrics of requests and connections.

use std::time::Duration;

use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::registry::Registry;

use super::{Histograms, short_histograms};

/// Metrics of requests and connections. Clones are the same metrics.
#[derive(Debug, Clone)]
pub struct HttpMetrics {
    requests: Family<Answered, Counter>,
    seconds: Histograms<Asked>,
    rejections: Family<Rejected, Counter>,
    /// Requests whose answer has not begun.
    pub in_flight: Gauge,
    /// Connections that are open.
    pub connections: Gauge,
    /// Panics in the handling of a request.
    pub panics: Counter,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Asked {
    method: &'static str,
    route: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Answered {
    method: &'static str,
    route: String,
    status: u16,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Rejected {
    reason: String,
}

impl Default for HttpMetrics {
    fn default() -> Self {
        Self {
            requests: Family::default(),
            seconds: short_histograms(),
            rejections: Family::default(),
            in_flight: Gauge::default(),
            connections: Gauge::default(),
            panics: Counter::default(),
        }
    }
}

impl HttpMetrics {
    /// Counts a request that was answered. `route` is the template of a route, never a path.
    pub fn note(&self, method: &'static str, route: &str, status: u16, took: Duration) {
        let route = route.to_owned();
        let answered = Answered {
            method,
            route: route.clone(),
            status,
        };
        self.requests.get_or_create(&answered).inc();
        self.seconds
            .get_or_create(&Asked { method, route })
            .observe(took.as_secs_f64());
    }

    /// Counts a refusal; `reason` is one of the fixed kinds of problem.
    pub fn reject(&self, reason: &str) {
        let reason = reason.replace('-', "_");
        self.rejections.get_or_create(&Rejected { reason }).inc();
    }

    pub(super) fn register(&self, registry: &mut Registry) {
        let Self {
            requests,
            seconds,
            rejections,
            in_flight,
            connections,
            panics,
        } = self.clone();
        registry.register(
            "http_requests",
            "Requests answered, by method, route and status",
            requests,
        );
        registry.register(
            "http_request_duration_seconds",
            "Time until an answer began",
            seconds,
        );
        registry.register(
            "http_rejections",
            "Requests refused, by the kind of problem they were answered with",
            rejections,
        );
        registry.register(
            "http_requests_in_flight",
            "Requests whose answer has not begun",
            in_flight,
        );
        registry.register("http_connections", "Connections open", connections);
        registry.register(
            "http_panics",
            "Panics in the handling of requests; each is a bug",
            panics,
        );
    }
}
