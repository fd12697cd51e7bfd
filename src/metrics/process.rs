//! Metrics of the process, measured when they are requested.

use std::fmt;

use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, EncodeMetric};
use prometheus_client::metrics::counter::ConstCounter;
use prometheus_client::metrics::gauge::ConstGauge;

use crate::host;

/// Measures the process.
#[derive(Debug)]
pub struct Process;

impl Collector for Process {
    fn encode(&self, mut encoder: DescriptorEncoder) -> fmt::Result {
        let Some(usage) = host::usage() else {
            return Ok(());
        };
        let mut write = |name: &str, help: &str, metric: &dyn EncodeMetric| {
            let encoder = encoder.encode_descriptor(name, help, None, metric.metric_type())?;
            metric.encode(encoder)
        };
        write(
            "process_resident_memory_bytes",
            "Memory of the process that is in RAM.",
            &ConstGauge::new(usage.resident_bytes),
        )?;
        write(
            "process_cpu_seconds",
            "Processor time of the process.",
            &ConstCounter::new(usage.cpu_seconds),
        )?;
        write(
            "process_open_fds",
            "Files, sockets and pipes that the process has open.",
            &ConstGauge::new(usage.open_files),
        )?;
        write(
            "process_threads",
            "Threads of the process.",
            &ConstGauge::new(usage.threads),
        )
    }
}
