//! `graspd serve`

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use super::daemon::{self, Signals};
use crate::config::Config;
use crate::http::Application;

/// Serves until SIGTERM, SIGINT or SIGHUP.
pub fn run(config: &Config) -> ExitCode {
    daemon::run(&config.log, serve(config))
}

async fn serve(config: &Config) -> Result<(), Box<dyn Error>> {
    let signals = Signals::catch()?;
    let application = Application::build(config).await?;
    let mut out = io::stdout();
    writeln!(out, "graspd listening on http://{}", application.address())?;
    out.flush()?;
    let stop = signals.stop(application.service().clone());
    application.run_until_stopped(stop).await;
    Ok(())
}
