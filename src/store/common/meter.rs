//! The time that statements take, and how many of them fail.

use std::time::Instant;

use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::histogram::Histogram;

use crate::metrics::{Operation, StoreMetrics};

/// Times statements of one kind and counts their failures. Clones are the same meter.
#[derive(Debug, Clone)]
pub struct Meter {
    seconds: Histogram,
    errors: Counter,
}

impl Meter {
    pub fn new(metrics: &StoreMetrics, operation: Operation) -> Self {
        Self {
            seconds: metrics.seconds(operation),
            errors: metrics.errors(operation),
        }
    }

    /// Starts the time of a statement or transaction; `failed` says what it counts as when it is given up half-way.
    pub fn start(&self, failed: bool) -> Timer {
        Timer {
            started: Instant::now(),
            failed,
            meter: self.clone(),
        }
    }
}

/// Times one statement or transaction for as long as it lives.
#[derive(Debug)]
pub struct Timer {
    started: Instant,
    /// Whether it counts as failed.
    pub failed: bool,
    meter: Meter,
}

impl Drop for Timer {
    fn drop(&mut self) {
        let Meter { seconds, errors } = &self.meter;
        seconds.observe(self.started.elapsed().as_secs_f64());
        if self.failed {
            errors.inc();
        }
    }
}
