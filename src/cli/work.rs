//! The threads of a command that plans or evaluates without a server, and its interruption.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::exit::{EXIT_INTERRUPTED, input_problem};
use crate::wire::Problem;

/// Returns a pool of this many threads, or of one for each processor.
pub(super) fn threads(count: Option<u16>) -> Result<rayon::ThreadPool, Problem> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(count.map_or(0, usize::from))
        .build()
        .map_err(|fault| input_problem(format!("cannot start the threads: {fault}")))
}

/// Returns a flag that Ctrl-C sets; a second Ctrl-C ends the process.
pub(super) fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&stop);
    std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .build();
        let Ok(runtime) = runtime else { return };
        while runtime.block_on(tokio::signal::ctrl_c()).is_ok() {
            if raised.swap(true, Ordering::Relaxed) {
                std::process::exit(EXIT_INTERRUPTED.into());
            }
        }
    });
    stop
}
