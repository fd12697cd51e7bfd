//! The log, the runtime and the signals of a process that runs until it is stopped.

use std::error::Error;
use std::process::ExitCode;

use tokio::signal::unix::{Signal, SignalKind, signal};
use tracing_subscriber::fmt::format::JsonFields;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer};

use super::log_lines::JsonLines;
use super::logs::Logs;
use crate::config::{Log, LogFormat};
use crate::jobs::Service;

/// The environment variable with the address to which traces are sent.
#[cfg(not(feature = "otel"))]
const TRACES: &str = "OTEL_EXPORTER_OTLP_ENDPOINT";

/// Starts the log, runs `work` to its end and returns the exit code.
pub fn run(config: &Log, work: impl Future<Output = Result<(), Box<dyn Error>>>) -> ExitCode {
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
    let outcome = runtime.block_on(work);
    // A planner that does not stop must not keep the process alive: its job is back in the queue.
    runtime.shutdown_background();
    #[cfg(feature = "otel")]
    traces.stop();
    logs.flush();
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => super::fail(fault),
    }
}

/// The signals that end a process.
pub struct Signals {
    terminate: Signal,
    interrupt: Signal,
    /// The terminal is gone.
    hangup: Signal,
}

impl Signals {
    /// Catches the signals from here on. Call it before the process announces itself: whoever reads the announcement may
    /// send one at once.
    pub fn catch() -> std::io::Result<Self> {
        Ok(Self {
            terminate: signal(SignalKind::terminate())?,
            interrupt: signal(SignalKind::interrupt())?,
            hangup: signal(SignalKind::hangup())?,
        })
    }

    /// Waits for the first signal. The second one cuts short the time that running jobs have to end.
    pub async fn stop(mut self, service: Service) {
        self.next().await;
        tracing::info!("stopping");
        tokio::spawn(async move {
            self.next().await;
            tracing::info!("stopping at once");
            service.hurry();
        });
    }

    async fn next(&mut self) {
        tokio::select! {
            _ = self.terminate.recv() => {}
            _ = self.interrupt.recv() => {}
            _ = self.hangup.recv() => {}
        }
    }
}

/// Returns the filter of the log lines.
pub fn log_filter(config: &Log) -> Result<EnvFilter, String> {
    EnvFilter::try_new(&config.log_level)
        .map_err(|fault| format!("--log-level {}: {fault}", config.log_level))
}

fn start_logging(
    config: &Log,
    #[cfg(feature = "otel")] traces: &crate::otel::Traces,
) -> Result<Logs, Box<dyn std::error::Error>> {
    let filter = log_filter(config)?;
    let logs = Logs::start()?;
    let writer = logs.clone();
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(move || writer.clone())
        // Internal errors would be printed, and printing may block or panic.
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
