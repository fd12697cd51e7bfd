//! How much memory the process may take.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::host::resident_bytes;

/// The bound on the memory of the process, and whether it was passed when it was last looked at.
#[derive(Debug)]
pub struct Memory {
    limit: Option<u64>,
    over: AtomicBool,
}

impl Memory {
    /// `limit` in bytes; without one nothing is bounded.
    pub fn new(limit: Option<u64>) -> Self {
        Self {
            limit,
            over: AtomicBool::new(false),
        }
    }

    /// Looks whether the process takes more than it may. Costs some 20 µs.
    pub fn look(&self) -> bool {
        let over = self
            .limit
            .is_some_and(|limit| resident_bytes().is_some_and(|taken| taken > limit));
        self.over.store(over, Ordering::Relaxed);
        over
    }

    /// What the last look found.
    pub fn is_over(&self) -> bool {
        self.over.load(Ordering::Relaxed)
    }

    pub fn limit(&self) -> Option<u64> {
        self.limit
    }
}
