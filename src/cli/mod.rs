//! The commands of the binary.

mod backup;
mod batch;
mod daemon;
mod doctor;
mod evaluate;
mod exit;
mod inspect;
mod keys;
mod log_lines;
mod logs;
mod mesh;
mod openapi;
mod output;
mod plan;
mod plot;
mod reference;
mod reproduce;
mod serve;
mod settings;
mod summary;
mod work;
mod worker;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

/// Plans force-closure grasps on triangle meshes
#[derive(Parser)]
#[command(name = "graspd", version, arg_required_else_help = true)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Serve over HTTP
    Serve(crate::config::Config),
    /// Only plan, for servers that share a database
    Worker(crate::config::WorkerConfig),
    /// Plan one grasp here, without a server
    Plan(plan::Plan),
    /// Plan many meshes on a server, as often interrupted as may be
    Batch(batch::Batch),
    /// Evaluate given grasps here, without a server
    Evaluate(evaluate::Evaluate),
    /// Tell what is in a mesh, and draw it
    Inspect(inspect::Inspect),
    /// Run the paper's experiments again, all methods side by side
    Reproduce(reproduce::Reproduce),
    /// Make, list and revoke API keys
    Keys(keys::Keys),
    /// Copy a data directory, while a server may run on it
    Backup(backup::Backup),
    /// Put a backup back
    Restore(backup::Restore),
    /// Look whether a server can run here, or does, and print its settings
    Doctor(doctor::Doctor),
    /// Write the OpenAPI description
    Openapi(openapi::Openapi),
    /// Write the reference of all settings, and what the page knows of them
    #[command(hide = true)]
    Reference(reference::Reference),
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let matches = CommandLine::command().get_matches();
    let line = match CommandLine::from_arg_matches(&matches) {
        Ok(line) => line,
        Err(fault) => fault.exit(),
    };
    match line.command {
        Command::Serve(config) => serve::run(&config),
        Command::Worker(config) => worker::run(&config),
        Command::Plan(plan) => plan.run(),
        Command::Batch(batch) => batch.run(),
        Command::Evaluate(evaluate) => evaluate.run(),
        Command::Inspect(inspect) => inspect.run(),
        Command::Reproduce(reproduce) => reproduce.run(),
        Command::Keys(keys) => keys.run(),
        Command::Doctor(doctor) => {
            let (_, given) = matches.subcommand().unwrap_or(("", &matches));
            doctor.run(given)
        }
        Command::Backup(backup) => backup.run(),
        Command::Restore(restore) => restore.run(),
        Command::Openapi(openapi) => openapi.run(),
        Command::Reference(reference) => reference.run(),
    }
}

/// Says what went wrong and ends with code 1.
fn fail(fault: impl std::fmt::Display) -> ExitCode {
    complain(format_args!("graspd: {fault}"));
    ExitCode::FAILURE
}

/// Writes a line to standard output and ends with code 0.
fn say(line: impl std::fmt::Display) -> ExitCode {
    let mut out = io::stdout().lock();
    let written = writeln!(out, "{line}").and_then(|()| out.flush());
    written.map_or_else(|fault| unwritten(&fault), |()| ExitCode::SUCCESS)
}

/// Writes a line to standard error, if that takes one.
fn complain(line: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Code 1 and the reason for what could not be written to standard output; a reader that has
/// seen enough is no fault.
fn unwritten(fault: &io::Error) -> ExitCode {
    if fault.kind() == io::ErrorKind::BrokenPipe {
        ExitCode::SUCCESS
    } else {
        fail(format_args!("cannot write to standard output: {fault}"))
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::CommandLine::command().debug_assert();
    }
}
