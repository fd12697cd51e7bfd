//! Traces for OpenTelemetry, over OTLP/HTTP without TLS, to a collector on the same host or network.
//!
//! Spans are those of `tracing`: one for a request, one for a run of a job.

use std::error::Error;
use std::time::Duration;

use axum::http::HeaderMap;
use opentelemetry::propagation::TextMapPropagator;
use opentelemetry::trace::TracerProvider;
use opentelemetry_http::HeaderExtractor;
use opentelemetry_otlp::SpanExporter;
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::propagation::TraceContextPropagator;
use opentelemetry_sdk::trace::SdkTracerProvider;
use tracing::{Span, Subscriber};
use tracing_opentelemetry::OpenTelemetrySpanExt;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::registry::LookupSpan;

/// The variable that turns traces on, with the address of the collector; the SDK reads the rest of `OTEL_*` itself.
const ENDPOINT: &str = "OTEL_EXPORTER_OTLP_ENDPOINT";
/// Longest time that sending the last spans may take.
const LAST_SPANS: Duration = Duration::from_secs(2);

/// Sends spans to a collector.
pub struct Traces(Option<SdkTracerProvider>);

impl Traces {
    /// Starts a thread that sends spans, if an endpoint is set. Must not be called on a tokio runtime.
    pub fn start() -> Result<Self, Box<dyn Error>> {
        if std::env::var_os(ENDPOINT).is_none_or(|endpoint| endpoint.is_empty()) {
            return Ok(Self(None));
        }
        let exporter = SpanExporter::builder().with_http().build()?;
        let mut resource = Resource::builder();
        if std::env::var_os("OTEL_SERVICE_NAME").is_none() {
            resource = resource.with_service_name("graspd");
        }
        let provider = SdkTracerProvider::builder()
            .with_batch_exporter(exporter)
            .with_resource(resource.build())
            .build();
        Ok(Self(Some(provider)))
    }

    /// Returns the layer that collects spans of level info and above.
    pub fn layer<S>(&self) -> Option<impl Layer<S> + use<S>>
    where
        S: Subscriber + for<'a> LookupSpan<'a> + Send + Sync,
    {
        let tracer = self.0.as_ref()?.tracer("graspd");
        let layer = tracing_opentelemetry::layer().with_tracer(tracer);
        Some(layer.with_filter(LevelFilter::INFO))
    }

    /// Sends the last spans. Must not be called on a tokio runtime.
    pub fn stop(self) {
        if let Some(provider) = self.0 {
            // The process is about to end: a failure can be reported to nobody.
            let _ = provider.shutdown_with_timeout(LAST_SPANS);
        }
    }
}

/// Makes `span` part of the trace that a request belongs to according to its headers (W3C traceparent).
pub fn adopt(span: &Span, headers: &HeaderMap) {
    let context = TraceContextPropagator::new().extract(&HeaderExtractor(headers));
    // Fails where spans are not collected.
    let _ = span.set_parent(context);
}
