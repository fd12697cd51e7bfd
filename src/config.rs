//! Every setting once: flag, environment variable, default and unit.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// What `graspd serve` can be told.
#[derive(Debug, Clone, Args)]
pub struct Config {
    /// Address and port to listen on; port 0 takes a free one
    #[arg(
        long,
        env = "GRASPD_LISTEN",
        value_name = "ADDRESS:PORT",
        default_value = "127.0.0.1:8080"
    )]
    pub listen: String,

    /// Folder of the database and the meshes; created when missing
    #[arg(
        long,
        env = "GRASPD_DATA_DIR",
        value_name = "FOLDER",
        default_value = "./graspd-data"
    )]
    pub data_dir: PathBuf,

    /// Jobs planned at the same time
    #[arg(
        long,
        env = "GRASPD_WORKERS",
        value_name = "COUNT",
        default_value_t = 1,
        value_parser = count(1024)
    )]
    pub workers: usize,

    /// Threads of one job [default: processors divided by workers, at least 1]
    #[arg(long, env = "GRASPD_THREADS_PER_JOB", value_name = "COUNT", value_parser = count(1024))]
    pub threads_per_job: Option<usize>,

    /// Jobs that may wait; one more is refused with 503
    #[arg(
        long,
        env = "GRASPD_QUEUE_CAPACITY",
        value_name = "COUNT",
        default_value_t = 10_000,
        value_parser = count(10_000_000)
    )]
    pub queue_capacity: usize,

    /// Largest upload, in bytes or with a unit such as 64MiB
    #[arg(
        long,
        env = "GRASPD_MAX_UPLOAD_BYTES",
        value_name = "BYTES",
        default_value = "256MiB",
        value_parser = bytes
    )]
    pub max_upload_bytes: u64,

    /// Most triangles of a mesh
    #[arg(
        long,
        env = "GRASPD_MAX_TRIANGLES",
        value_name = "COUNT",
        default_value_t = 2_000_000,
        value_parser = count(100_000_000)
    )]
    pub max_triangles: usize,

    /// Most vertices of a mesh, in formats whose triangles share them
    #[arg(
        long,
        env = "GRASPD_MAX_VERTICES",
        value_name = "COUNT",
        default_value_t = 6_000_000,
        value_parser = count(300_000_000)
    )]
    pub max_vertices: usize,

    /// Most memory that the vertices and triangles of one file may take while it is read
    #[arg(
        long,
        env = "GRASPD_MAX_MESH_MEMORY",
        value_name = "BYTES",
        default_value = "1GiB",
        value_parser = bytes
    )]
    pub max_mesh_memory: u64,

    /// Longest that reading one mesh file may take, in seconds, up to 3600
    #[arg(
        long,
        env = "GRASPD_MAX_PARSE_SECONDS",
        value_name = "SECONDS",
        default_value = "30",
        value_parser = seconds
    )]
    pub max_parse_seconds: f64,

    /// Longest that one job may run, in seconds of wall-clock time, up to 3600
    #[arg(
        long,
        env = "GRASPD_MAX_JOB_SECONDS",
        value_name = "SECONDS",
        default_value = "3600",
        value_parser = seconds
    )]
    pub max_job_seconds: f64,

    /// Free disk space below which new work is refused with 507
    #[arg(
        long,
        env = "GRASPD_MIN_FREE_DISK",
        value_name = "BYTES",
        default_value = "64MiB",
        value_parser = bytes
    )]
    pub min_free_disk: u64,

    /// How log lines are written to standard error
    #[arg(
        long,
        env = "GRASPD_LOG_FORMAT",
        value_enum,
        default_value_t = LogFormat::Text
    )]
    pub log_format: LogFormat,

    /// error, warn, info, debug, trace, or a filter such as info,graspd=debug
    #[arg(
        long,
        env = "GRASPD_LOG_LEVEL",
        value_name = "LEVEL",
        default_value = "info"
    )]
    pub log_level: String,
}

/// How log lines are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// For people.
    Text,
    /// One JSON object a line.
    Json,
}

impl Config {
    /// Threads that plan one job.
    pub fn job_threads(&self) -> usize {
        self.threads_per_job.unwrap_or_else(|| {
            let processors = std::thread::available_parallelism().map_or(1, |count| count.get());
            (processors / self.workers).max(1)
        })
    }
}

fn count(max: usize) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync + 'static {
    move |text| {
        text.parse()
            .ok()
            .filter(|count| (1..=max).contains(count))
            .ok_or_else(|| format!("a whole number from 1 to {max} is wanted"))
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|seconds| *seconds > 0.0 && *seconds <= 3600.0)
        .ok_or_else(|| "a number of seconds above 0, at most 3600, is wanted".to_owned())
}

fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit: u64 = match text[digits.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => 1,
        "kb" => 1_000,
        "mb" => 1_000_000,
        "gb" => 1_000_000_000,
        "k" | "kib" => 1 << 10,
        "m" | "mib" => 1 << 20,
        "g" | "gib" => 1 << 30,
        _ => 0,
    };
    digits
        .trim_end()
        .parse::<u64>()
        .ok()
        .and_then(|number| number.checked_mul(unit))
        .filter(|bytes| *bytes > 0)
        .ok_or_else(|| "a size such as 1048576, 64MiB or 2GB is wanted".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_with_and_without_unit() {
        assert_eq!(bytes("1048576"), Ok(1 << 20));
        assert_eq!(bytes("64MiB"), Ok(64 << 20));
        assert_eq!(bytes("2 GB"), Ok(2_000_000_000));
        for wrong in [
            "",
            "MiB",
            "-1",
            "5 parsecs",
            "99999999999999999999",
            "99999999999G",
        ] {
            assert!(bytes(wrong).is_err(), "{wrong:?}");
        }
    }
}
