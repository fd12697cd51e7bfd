//! Metrics of the store.

use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::Registry;

use super::{Histograms, short_histograms};

/// Metrics of the store. Clones are the same metrics.
#[derive(Debug, Clone)]
pub struct StoreMetrics {
    seconds: Histograms<Label>,
    errors: Family<Label, Counter>,
    /// Bytes of meshes received.
    pub upload_bytes: Counter,
}

/// A class of statements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    Read,
    Write,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Label {
    operation: &'static str,
}

impl From<Operation> for Label {
    fn from(operation: Operation) -> Self {
        let operation = match operation {
            Operation::Read => "read",
            Operation::Write => "write",
        };
        Self { operation }
    }
}

impl Default for StoreMetrics {
    fn default() -> Self {
        Self {
            seconds: short_histograms(),
            errors: Family::default(),
            upload_bytes: Counter::default(),
        }
    }
}

impl StoreMetrics {
    /// Returns the histogram of the time that statements of this class take, including the wait for a connection.
    pub fn seconds(&self, operation: Operation) -> Histogram {
        self.seconds.get_or_create_owned(&operation.into())
    }

    /// Returns the counter of failed statements of this class.
    pub fn errors(&self, operation: Operation) -> Counter {
        self.errors.get_or_create_owned(&operation.into())
    }

    pub(super) fn register(&self, registry: &mut Registry) {
        let Self {
            seconds,
            errors,
            upload_bytes,
        } = self.clone();
        registry.register(
            "store_operation_seconds",
            "Time of a statement or transaction of the store, with the wait for a connection",
            seconds,
        );
        registry.register(
            "store_errors",
            "Statements of the store that failed",
            errors,
        );
        registry.register("upload_bytes", "Bytes of meshes received", upload_bytes);
    }
}
