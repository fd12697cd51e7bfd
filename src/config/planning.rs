//! The settings of the workers of a process, and its limits.

use std::time::Duration;

use clap::Args;

use super::parse::{bytes, count, count_from, memory, pause, seconds};
use crate::host::memory_total;
use crate::jobs::IngestLimits;
use graspd_mesh_io::Limits;

/// The settings of the workers of a process, and its limits.
#[derive(Debug, Clone, Args)]
pub struct Planning {
    /// Number of jobs that run at the same time; may be 0 for a server whose database other workers share
    #[arg(
        long,
        env = "GRASPD_WORKERS",
        value_name = "COUNT",
        default_value_t = 1,
        value_parser = count_from(0, 1024)
    )]
    pub workers: usize,

    /// Threads of one job [default: processors divided by workers, at least 1]
    #[arg(long, env = "GRASPD_THREADS_PER_JOB", value_name = "COUNT", value_parser = count(1024))]
    pub threads_per_job: Option<usize>,

    /// Most triangles of a mesh
    #[arg(
        long,
        env = "GRASPD_MAX_TRIANGLES",
        value_name = "COUNT",
        default_value_t = 2_000_000,
        value_parser = count(100_000_000)
    )]
    pub max_triangles: usize,

    /// Most vertices of a mesh, in formats whose triangles share vertices
    #[arg(
        long,
        env = "GRASPD_MAX_VERTICES",
        value_name = "COUNT",
        default_value_t = 6_000_000,
        value_parser = count(300_000_000)
    )]
    pub max_vertices: usize,

    /// Most memory for the vertices and triangles of one file while it is read
    #[arg(
        long,
        env = "GRASPD_MAX_MESH_MEMORY",
        value_name = "BYTES",
        default_value = "1GiB",
        value_parser = bytes
    )]
    pub max_mesh_memory: u64,

    /// Longest time that reading one mesh file may take, in seconds, up to 3600
    #[arg(
        long,
        env = "GRASPD_MAX_PARSE_SECONDS",
        value_name = "SECONDS",
        default_value = "30",
        value_parser = seconds
    )]
    pub max_parse_seconds: f64,

    /// Memory that the server may use before it stops the run that started last, at least 64MiB
    /// [default: three quarters of what the machine has or the control group allows]
    #[arg(long, env = "GRASPD_MAX_MEMORY", value_name = "BYTES", value_parser = memory)]
    pub max_memory: Option<u64>,

    /// How long running jobs may continue after SIGTERM or SIGINT before they go back to the queue, such as 90s; after a
    /// second signal they go back at once
    #[arg(
        long,
        env = "GRASPD_DRAIN",
        value_name = "TIME",
        default_value = "0s",
        value_parser = pause
    )]
    pub drain: Duration,
}

impl Planning {
    /// Threads that plan one job.
    pub fn job_threads(&self) -> usize {
        self.threads_per_job.unwrap_or_else(|| {
            let processors = std::thread::available_parallelism().map_or(1, |count| count.get());
            (processors / self.workers.max(1)).max(1)
        })
    }

    /// Most bytes of memory to use; no limit if the system does not report its memory.
    pub fn memory_limit(&self) -> Option<u64> {
        let most = || memory_total().map(|bytes| bytes / 4 * 3);
        self.max_memory.or_else(most)
    }

    /// The limits on reading a mesh file.
    pub fn ingest_limits(&self) -> IngestLimits {
        IngestLimits {
            mesh: Limits {
                triangles: self.max_triangles,
                vertices: self.max_vertices,
                memory: usize::try_from(self.max_mesh_memory).unwrap_or(usize::MAX),
            },
            time: Duration::from_secs_f64(self.max_parse_seconds),
        }
    }
}
