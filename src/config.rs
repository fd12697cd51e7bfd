//! Every setting once: flag, environment variable, default and unit.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

use crate::host::memory_total;
use crate::jobs::webhooks::{AllowedHosts, PrivateHosts, SecretText};

/// A hundred years, in seconds.
const MAX_RETENTION_S: u64 = 36_500 * 86_400;

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

    /// Whether an API key is wanted, of those that `graspd keys` made [default: off where only this machine can
    /// connect; anywhere else it has to be said]
    #[arg(long, env = "GRASPD_AUTH", value_enum, value_name = "AUTH")]
    pub auth: Option<Auth>,

    /// Jobs of one API key that may wait; one more is refused with 429
    #[arg(
        long,
        env = "GRASPD_MAX_QUEUED_PER_KEY",
        value_name = "COUNT",
        default_value_t = 1000,
        value_parser = count(10_000_000)
    )]
    pub max_queued_per_key: usize,

    /// Most bytes that the mesh files of one API key may have in all; more are refused with 429
    #[arg(
        long,
        env = "GRASPD_MAX_MESH_BYTES_PER_KEY",
        value_name = "BYTES",
        default_value = "10GiB",
        value_parser = bytes
    )]
    pub max_mesh_bytes_per_key: u64,

    /// Most requests a minute of one API key or, without keys, one address; more are refused with 429
    /// [default: no limit]
    #[arg(long, env = "GRASPD_RATE_LIMIT", value_name = "COUNT", value_parser = count(10_000_000))]
    pub rate_limit: Option<usize>,

    /// How long ended jobs and unused meshes are kept, such as 90s, 12h or 7d, or "forever"
    #[arg(
        long,
        env = "GRASPD_RETENTION",
        value_name = "TIME",
        default_value = "7d",
        value_parser = period
    )]
    pub retention: Period,

    /// Origins whose pages may use the service from a browser, such as https://a.example, separated by commas,
    /// or * for all [default: none]
    #[arg(
        long,
        env = "GRASPD_CORS_ORIGINS",
        value_name = "ORIGINS",
        value_delimiter = ','
    )]
    pub cors_origins: Vec<String>,

    /// Connections open at a time; more wait. One address may have three quarters of them
    #[arg(
        long,
        env = "GRASPD_MAX_CONNECTIONS",
        value_name = "COUNT",
        default_value_t = 1024,
        value_parser = count(1_000_000)
    )]
    pub max_connections: usize,

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

    /// Memory that the server may take before it stops the run that started last, at least 64MiB
    /// [default: three quarters of what the machine has or the control group allows]
    #[arg(long, env = "GRASPD_MAX_MEMORY", value_name = "BYTES", value_parser = memory)]
    pub max_memory: Option<u64>,

    /// Hosts that callback_url may name, comma-separated: HOST or HOST:PORT, HOST a name, *.NAME or
    /// an address; https, or plain http with http:// before it [default: none, webhooks are off]
    #[arg(
        long,
        env = "GRASPD_WEBHOOK_HOSTS",
        value_name = "HOSTS",
        default_value = "",
        hide_default_value = true
    )]
    pub webhook_hosts: AllowedHosts,

    /// Hosts of these that may have addresses which are not public, comma-separated [default: none]
    #[arg(
        long,
        env = "GRASPD_WEBHOOK_PRIVATE_HOSTS",
        value_name = "HOSTS",
        default_value = "",
        hide_default_value = true
    )]
    pub webhook_private_hosts: PrivateHosts,

    /// What webhooks are signed with: whsec_ and 24 to 64 bytes in base64; several, with spaces
    /// between, sign all. Give it in the environment: flags can be seen by others
    #[arg(
        long,
        env = "GRASPD_WEBHOOK_SECRET",
        value_name = "SECRET",
        hide_env_values = true
    )]
    pub webhook_secret: Option<SecretText>,

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

/// Who may come in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Auth {
    /// Whoever has an API key; each sees only what is its own.
    Keys,
    /// Anyone.
    Off,
}

/// How long something is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Period {
    For(Duration),
    Forever,
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

    /// Most bytes of memory to take; no limit where the system does not tell how much there is.
    pub fn memory_limit(&self) -> Option<u64> {
        let most = || memory_total().map(|bytes| bytes / 4 * 3);
        self.max_memory.or_else(most)
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

/// Reads a time with its unit, or `forever`.
pub fn period(text: &str) -> Result<Period, String> {
    let text = text.trim();
    if text == "forever" {
        return Ok(Period::Forever);
    }
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &text[digits.len()..] {
        "s" => 1,
        "m" => 60,
        "h" => 3600,
        "d" => 86_400,
        _ => 0,
    };
    digits
        .parse::<u64>()
        .ok()
        .and_then(|number| number.checked_mul(unit))
        .filter(|seconds| (1..=MAX_RETENTION_S).contains(seconds))
        .map(|seconds| Period::For(Duration::from_secs(seconds)))
        .ok_or_else(|| {
            "a time such as 90s, 15m, 12h or 7d, up to 36500d, or forever is wanted".to_owned()
        })
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

/// A server takes a few ten megabytes before it does anything.
fn memory(text: &str) -> Result<u64, String> {
    match bytes(text)? {
        bytes if bytes >= 64 << 20 => Ok(bytes),
        _ => Err("at least 64MiB is wanted".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn retentions_are_read_with_their_unit() {
        assert_eq!(period("90s"), Ok(Period::For(Duration::from_secs(90))));
        assert_eq!(period("7d"), Ok(Period::For(Duration::from_secs(604_800))));
        assert_eq!(period("forever"), Ok(Period::Forever));
        for wrong in [
            "",
            "0s",
            "7",
            "-1d",
            "7 parsecs",
            "99999d",
            "1.5h",
            "99999999999999999999s",
        ] {
            assert!(period(wrong).is_err(), "{wrong:?}");
        }
    }

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
