//! Work that a command does here: with how many threads, and until when.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::exit::{EXIT_INTERRUPTED, input_problem};
use crate::wire::Problem;

/// As many threads as wanted, or one a processor.
pub(super) fn threads(wanted: Option<u16>) -> Result<rayon::ThreadPool, Problem> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(wanted.map_or(0, usize::from))
        .build()
        .map_err(|fault| input_problem(format!("cannot start the threads: {fault}")))
}

/// A flag that Ctrl-C raises; a second one ends the process.
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
