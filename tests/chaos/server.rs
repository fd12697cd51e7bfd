//! One server that keeps its data in a folder.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use testkit::process::Graspd;

/// The environment in which the server runs.
pub fn command() -> Command {
    let mut command = Command::new(testkit::process::binary());
    command
        .env("GRASPD_WORKERS", "2")
        .env("GRASPD_THREADS_PER_JOB", "1")
        .env("GRASPD_LOG_LEVEL", "error");
    command
}

/// Starts the server, and asserts that it is ready as soon as promised, or as a busy machine has it.
pub fn start(command: Command, data: &Path) -> Graspd {
    let begun = Instant::now();
    let server = Graspd::spawn(command, data, &[]);
    let took = begun.elapsed();
    assert!(took < crate::promised(2), "ready after {took:?}");
    server
}
