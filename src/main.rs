//! The `graspd` binary: parse the command line and hand over to [`graspd::cli`].

use std::process::ExitCode;

/// Gives memory back to the system soon after it is freed, which the limit on the memory of a server rests on.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    graspd::cli::main()
}
