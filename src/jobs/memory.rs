//! How much memory the process may take.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::host::resident_bytes;

/// The limit on the memory of the process, and whether the last measurement exceeded it.
#[derive(Debug)]
pub struct Memory {
    limit: Option<u64>,
    is_over: AtomicBool,
}

impl Memory {
    /// A limit in bytes; `None` is no limit.
    pub fn new(limit: Option<u64>) -> Self {
        Self {
            limit,
            is_over: AtomicBool::new(false),
        }
    }

    /// Measures the memory of the process and returns whether it exceeds the limit. Costs some 20 µs.
    pub fn measure(&self) -> bool {
        let is_over = self
            .limit
            .is_some_and(|limit| resident_bytes().is_some_and(|taken| taken > limit));
        self.is_over.store(is_over, Ordering::Relaxed);
        is_over
    }

    /// Returns whether the last measurement exceeded the limit.
    pub fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Relaxed)
    }

    pub fn limit(&self) -> Option<u64> {
        self.limit
    }
}
