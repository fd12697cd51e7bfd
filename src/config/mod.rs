//! The settings of the server. Each is defined once, with its flag, environment variable, default, unit and help.

mod log;
mod parse;
mod planning;
mod store;
mod worker;

pub use log::{Log, LogFormat};
pub use parse::{Period, period};
pub use planning::Planning;
pub use store::Store;
pub use worker::WorkerConfig;

use clap::{Args, ValueEnum};

use self::parse::{bytes, count, seconds};
use crate::jobs::webhooks::{AllowedHosts, PrivateHosts, SecretText};

/// The settings of `graspd serve`.
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

    #[command(flatten)]
    pub store: Store,

    #[command(flatten)]
    pub planning: Planning,

    /// Number of jobs that may wait; further jobs are refused with 503
    #[arg(
        long,
        env = "GRASPD_QUEUE_CAPACITY",
        value_name = "COUNT",
        default_value_t = 10_000,
        value_parser = count(10_000_000)
    )]
    pub queue_capacity: usize,

    /// Whether requests need an API key, created by `graspd keys` [default: off if only this machine can connect;
    /// otherwise it must be given]
    #[arg(long, env = "GRASPD_AUTH", value_enum, value_name = "AUTH")]
    pub auth: Option<Auth>,

    /// Number of jobs of one API key that may wait; further jobs are refused with 429
    #[arg(
        long,
        env = "GRASPD_MAX_QUEUED_PER_KEY",
        value_name = "COUNT",
        default_value_t = 1000,
        value_parser = count(10_000_000)
    )]
    pub max_queued_per_key: usize,

    /// Total bytes of the mesh files of one API key; more are refused with 429
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

    /// Number of open connections; further clients wait. One address may have three quarters of them
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

    /// Longest run of one job, in seconds of wall-clock time, up to 3600
    #[arg(
        long,
        env = "GRASPD_MAX_JOB_SECONDS",
        value_name = "SECONDS",
        default_value = "3600",
        value_parser = seconds
    )]
    pub max_job_seconds: f64,

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

    /// Those webhook hosts that may have addresses that are not public, comma-separated [default: none]
    #[arg(
        long,
        env = "GRASPD_WEBHOOK_PRIVATE_HOSTS",
        value_name = "HOSTS",
        default_value = "",
        hide_default_value = true
    )]
    pub webhook_private_hosts: PrivateHosts,

    /// Secret with which webhooks are signed: whsec_ and 24 to 64 bytes in base64. With several, separated by spaces,
    /// messages are signed with each. Set it in the environment: other users can see flags
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

    #[command(flatten)]
    pub log: Log,
}

/// Which clients may use the service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Auth {
    /// Clients with an API key; each sees only its own data.
    Keys,
    /// All clients.
    Off,
}
