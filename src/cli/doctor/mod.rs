//! `graspd doctor`

mod data;
mod database;
mod host;
mod settings;
mod start;

use std::fmt::Display;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::{ArgMatches, Args};
use serde::Serialize;

use self::settings::Setting;
use crate::config::Config;

/// Flags of `graspd doctor`: those of `graspd serve`, and how to report.
#[derive(Args)]
#[command(
    after_help = "Nothing is changed, and a server may run on the data directory. Use the settings of the server.\n\n\
    Exit codes: 0 no check has failed, though there may be warnings; 1 something is wrong, with advice; \
    2 a flag cannot be used."
)]
pub struct Doctor {
    #[command(flatten)]
    config: Config,

    /// Read everything: compare indices with tables, and mesh files with their names; data directories only
    #[arg(long)]
    deep: bool,

    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The outcome of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Status {
    Ok,
    /// It works, but not as well or not for as long as it could.
    Warning,
    Wrong,
}

/// A check and its outcome.
#[derive(Debug, Serialize)]
struct Finding {
    check: &'static str,
    status: Status,
    detail: String,
    /// What to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    advice: Option<&'static str>,
}

impl Finding {
    fn ok(check: &'static str, detail: impl Display) -> Self {
        Self {
            check,
            status: Status::Ok,
            detail: detail.to_string(),
            advice: None,
        }
    }

    fn warning(check: &'static str, detail: impl Display, advice: &'static str) -> Self {
        Self {
            check,
            status: Status::Warning,
            detail: detail.to_string(),
            advice: Some(advice),
        }
    }

    fn wrong(check: &'static str, detail: impl Display, advice: &'static str) -> Self {
        Self {
            status: Status::Wrong,
            ..Self::warning(check, detail, advice)
        }
    }
}

#[derive(Serialize)]
struct Report {
    ok: bool,
    version: &'static str,
    findings: Vec<Finding>,
    settings: Vec<Setting>,
}

impl Doctor {
    /// Runs all checks, prints the report and returns the exit code. `matches` are those of this command.
    pub fn run(self, matches: &ArgMatches) -> ExitCode {
        let runtime = match tokio::runtime::Runtime::new() {
            Ok(runtime) => runtime,
            Err(fault) => return super::fail(fault),
        };
        let mut findings = match &self.config.store.store {
            Some(url) => runtime.block_on(database::findings(url)),
            None => runtime.block_on(data::findings(&self.config, self.deep)),
        };
        findings.extend(runtime.block_on(host::findings(&self.config)));
        findings.extend(runtime.block_on(start::findings(&self.config)));
        findings.extend(settings::unknown());
        let report = Report {
            ok: findings
                .iter()
                .all(|finding| finding.status != Status::Wrong),
            version: env!("CARGO_PKG_VERSION"),
            findings,
            settings: settings::effective(matches),
        };
        match report.print(self.json) {
            Err(fault) => super::cannot_print(&fault),
            Ok(()) if report.ok => ExitCode::SUCCESS,
            Ok(()) => ExitCode::FAILURE,
        }
    }
}

impl Report {
    fn print(&self, json: bool) -> io::Result<()> {
        let mut out = io::stdout().lock();
        if json {
            serde_json::to_writer_pretty(&mut out, self)?;
            writeln!(out)?;
            return out.flush();
        }
        writeln!(out, "graspd {}", self.version)?;
        for finding in &self.findings {
            let status = match finding.status {
                Status::Ok => "ok     ",
                Status::Warning => "warning",
                Status::Wrong => "WRONG  ",
            };
            writeln!(out, "{status}  {}: {}", finding.check, finding.detail)?;
            if let Some(advice) = finding.advice {
                writeln!(out, "         {advice}")?;
            }
        }
        writeln!(out, "\nsettings")?;
        for setting in &self.settings {
            let value = setting.value.as_deref().unwrap_or("(not set)");
            writeln!(out, "  {} = {value}  ({})", setting.flag, setting.source)?;
        }
        out.flush()
    }
}
