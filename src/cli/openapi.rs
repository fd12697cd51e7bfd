//! `graspd openapi`

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

/// Flags of `graspd openapi`.
#[derive(Args)]
pub struct Openapi {
    /// Write to this file instead of standard output
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Openapi {
    /// Writes the description.
    pub fn run(self) -> ExitCode {
        let text = match crate::http::openapi_json() {
            Ok(text) => text,
            Err(fault) => return super::fail(fault),
        };
        let Some(path) = self.output else {
            let mut out = io::stdout().lock();
            let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
            return written
                .map_or_else(|fault| super::cannot_print(&fault), |()| ExitCode::SUCCESS);
        };
        match std::fs::write(&path, text) {
            Ok(()) => ExitCode::SUCCESS,
            Err(fault) => super::fail(format_args!("cannot write {}: {fault}", path.display())),
        }
    }
}
