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
    /// Plan the jobs of servers that share a database
    Worker(crate::config::WorkerConfig),
    /// Plan one grasp without a server
    Plan(plan::Plan),
    /// Plan many meshes on a server; an interrupted run can be resumed
    Batch(batch::Batch),
    /// Evaluate given grasps without a server
    Evaluate(evaluate::Evaluate),
    /// Report what a mesh file contains, and draw it
    Inspect(inspect::Inspect),
    /// Repeat the experiments of the paper with all methods
    Reproduce(reproduce::Reproduce),
    /// Create, list and revoke API keys
    Keys(keys::Keys),
    /// Copy a data directory, even while a server runs on it
    Backup(backup::Backup),
    /// Restore a backup
    Restore(backup::Restore),
    /// Check whether a server can run here, or runs, and print its settings
    Doctor(doctor::Doctor),
    /// Write the OpenAPI description
    Openapi(openapi::Openapi),
    /// Write the reference of all settings, and the definitions that the page uses
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

/// Prints a fault and returns exit code 1.
fn fail(fault: impl std::fmt::Display) -> ExitCode {
    print_error(format_args!("graspd: {fault}"));
    ExitCode::FAILURE
}

/// Prints a line to standard output and returns exit code 0.
fn print_line(line: impl std::fmt::Display) -> ExitCode {
    let mut out = io::stdout().lock();
    let written = writeln!(out, "{line}").and_then(|()| out.flush());
    written.map_or_else(|fault| cannot_print(&fault), |()| ExitCode::SUCCESS)
}

/// Prints a line to standard error. If that fails, the line is lost.
fn print_error(line: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Reports that standard output cannot be written and returns exit code 1. A reader that has closed the pipe is no fault.
fn cannot_print(fault: &io::Error) -> ExitCode {
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
