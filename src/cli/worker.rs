//! `graspd worker`

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use super::daemon::{self, Signals};
use crate::config::WorkerConfig;
use crate::http::WorkerApplication;

/// Plans until SIGTERM, SIGINT or SIGHUP.
pub fn run(config: &WorkerConfig) -> ExitCode {
    daemon::run(&config.log, work(config))
}

async fn work(config: &WorkerConfig) -> Result<(), Box<dyn Error>> {
    let signals = Signals::catch()?;
    let application = WorkerApplication::build(config).await?;
    let mut out = io::stdout();
    match application.address() {
        Some(address) => writeln!(out, "graspd worker listening on http://{address}")?,
        None => writeln!(out, "graspd worker planning")?,
    }
    out.flush()?;
    let stop = signals.stop(application.service().clone());
    application.run_until_stopped(stop).await;
    Ok(())
}
