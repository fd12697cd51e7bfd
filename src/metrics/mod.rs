//! Metrics for Prometheus.
//!
//! Each service has a registry of its own, so that several in one process do not mix. The values of every label come
//! from a fixed set: no client can make the number of series grow.

mod http;
mod jobs;
mod process;
mod store;

pub use http::HttpMetrics;
pub use jobs::{JobMetrics, RunEnd};
pub use store::{Operation, StoreMetrics};

use std::fmt;

use prometheus_client::encoding::{prometheus_text, text};
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::metrics::info::Info;
use prometheus_client::registry::Registry;

/// Upper bounds of the buckets for short operations, in seconds.
const SHORT_SECONDS: [f64; 14] = [
    0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 30.0,
];
/// Upper bounds of the buckets for runs of up to an hour, in seconds.
const LONG_SECONDS: [f64; 14] = [
    0.005, 0.02, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 15.0, 60.0, 300.0, 900.0, 1800.0, 3600.0,
];

/// One histogram for each value of the labels `L`.
type Histograms<L> = Family<L, Histogram, fn() -> Histogram>;

fn short_histograms<L: Clone + Eq + std::hash::Hash>() -> Histograms<L> {
    Family::new_with_constructor(|| Histogram::new(SHORT_SECONDS))
}

fn long_histograms<L: Clone + Eq + std::hash::Hash>() -> Histograms<L> {
    Family::new_with_constructor(|| Histogram::new(LONG_SECONDS))
}

/// A format of the metrics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// The Prometheus text format, version 0.0.4.
    Text,
    /// OpenMetrics 1.0.
    OpenMetrics,
}

impl Format {
    /// Returns the media type.
    pub fn content_type(self) -> &'static str {
        match self {
            Self::Text => prometheus_text::CONTENT_TYPE,
            Self::OpenMetrics => "application/openmetrics-text; version=1.0.0; charset=utf-8",
        }
    }
}

/// All metrics of one service.
#[derive(Debug)]
pub struct Metrics {
    registry: Registry,
    pub http: HttpMetrics,
    pub jobs: JobMetrics,
}

impl Metrics {
    /// All metrics at zero, but for those of the store, which counts already.
    pub fn new(store: &StoreMetrics, queue_capacity: u32) -> Self {
        let mut registry = Registry::with_prefix("graspd");
        registry.register(
            "build",
            "The version that runs",
            Info::new([("version", env!("CARGO_PKG_VERSION"))]),
        );
        let (http, jobs) = (HttpMetrics::default(), JobMetrics::default());
        http.register(&mut registry);
        jobs.register(&mut registry);
        let capacity: Gauge = Gauge::default();
        capacity.set(queue_capacity.into());
        registry.register("queue_capacity", "Jobs that may wait", capacity);
        store.register(&mut registry);
        registry.register_collector(Box::new(process::Process));
        Self {
            registry,
            http,
            jobs,
        }
    }

    /// Writes all metrics as they are now.
    pub fn encode(&self, format: Format) -> Result<String, fmt::Error> {
        let mut text = String::new();
        match format {
            Format::Text => prometheus_text::encode(&mut text, &self.registry)?,
            Format::OpenMetrics => text::encode(&mut text, &self.registry)?,
        }
        Ok(text)
    }
}

/// Counts as one in a gauge until it is dropped.
#[derive(Debug)]
pub struct Held(Gauge);

impl Held {
    /// Increments the gauge.
    pub fn new(gauge: &Gauge) -> Self {
        gauge.inc();
        Self(gauge.clone())
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.0.dec();
    }
}
