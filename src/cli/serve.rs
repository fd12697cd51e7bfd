//! `graspd serve`

use std::io::{self, Write};
use std::process::ExitCode;

use tokio::signal::unix::{SignalKind, signal};
use tracing_subscriber::fmt::format::JsonFields;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer};

use super::log_lines::JsonLines;
use super::logs::Logs;
use crate::config::{Config, LogFormat};
use crate::http::Application;

/// Where traces would go.
#[cfg(not(feature = "otel"))]
const TRACES: &str = "OTEL_EXPORTER_OTLP_ENDPOINT";

/// Serves until SIGTERM, SIGINT or SIGHUP.
pub fn run(config: &Config) -> ExitCode {
    #[cfg(feature = "otel")]
    let traces = match crate::otel::Traces::start() {
        Ok(traces) => traces,
        Err(fault) => return super::fail(format_args!("traces cannot be sent: {fault}")),
    };
    let started = start_logging(
        config,
        #[cfg(feature = "otel")]
        &traces,
    );
    let logs = match started {
        Ok(logs) => logs,
        Err(fault) => return super::fail(fault),
    };
    #[cfg(not(feature = "otel"))]
    if std::env::var_os(TRACES).is_some_and(|endpoint| !endpoint.is_empty()) {
        tracing::warn!(
            "{TRACES} is set, but this graspd was built without the feature otel and sends no traces"
        );
    }
    let runtime = match tokio::runtime::Runtime::new() {
        Ok(runtime) => runtime,
        Err(fault) => return super::fail(fault),
    };
    let outcome = runtime.block_on(serve(config));
    // A planner that does not stop must not keep the process: its job is back in the queue.
    runtime.shutdown_background();
    #[cfg(feature = "otel")]
    traces.stop();
    logs.flush();
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => super::fail(fault),
    }
}

async fn serve(config: &Config) -> Result<(), Box<dyn std::error::Error>> {
    // Before anything is announced: a signal must never find the default handler afterwards.
    let mut terminate = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    // The terminal is gone.
    let mut hangup = signal(SignalKind::hangup())?;
    let application = Application::build(config).await?;
    let mut out = io::stdout();
    writeln!(out, "graspd listening on http://{}", application.address())?;
    out.flush()?;
    let stop = async move {
        tokio::select! {
            _ = terminate.recv() => {}
            _ = interrupt.recv() => {}
            _ = hangup.recv() => {}
        }
        tracing::info!("stopping");
    };
    application.run_until_stopped(stop).await;
    Ok(())
}

/// Which lines are logged.
pub fn log_filter(config: &Config) -> Result<EnvFilter, String> {
    EnvFilter::try_new(&config.log_level)
        .map_err(|fault| format!("--log-level {}: {fault}", config.log_level))
}

fn start_logging(
    config: &Config,
    #[cfg(feature = "otel")] traces: &crate::otel::Traces,
) -> Result<Logs, Box<dyn std::error::Error>> {
    let filter = log_filter(config)?;
    let logs = Logs::start()?;
    let writer = logs.clone();
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(move || writer.clone())
        // Those would be printed, and printing may block or panic.
        .log_internal_errors(false);
    let lines = match config.log_format {
        LogFormat::Text => lines.with_ansi(false).with_filter(filter).boxed(),
        LogFormat::Json => lines
            .fmt_fields(JsonFields::new())
            .event_format(JsonLines)
            .with_filter(filter)
            .boxed(),
    };
    let subscriber = tracing_subscriber::registry().with(lines);
    #[cfg(feature = "otel")]
    let subscriber = subscriber.with(traces.layer());
    subscriber.try_init()?;
    // The default hook writes to standard error itself, and waits for it.
    std::panic::set_hook(Box::new(|panic| {
        let panic = panic.to_string();
        tracing::error!(panic, "panic");
    }));
    Ok(logs)
}
