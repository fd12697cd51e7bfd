//! The `graspd` binary: parse the command line and hand over to [`graspd::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    graspd::cli::main()
}
