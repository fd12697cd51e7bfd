//! The settings of `graspd worker`.

use clap::Args;

use super::{Log, Planning};

/// The settings of a process that only plans.
#[derive(Debug, Clone, Args)]
pub struct WorkerConfig {
    /// The PostgreSQL database of the servers: postgres://USER:PASSWORD@HOST:PORT/DATABASE. Give it in the environment:
    /// others can see flags
    #[arg(long, env = "GRASPD_STORE", value_name = "URL", hide_env_values = true)]
    pub store: String,

    #[command(flatten)]
    pub planning: Planning,

    /// Address and port that answer /healthz, /readyz and /metrics, and nothing else [default: none]
    #[arg(long, env = "GRASPD_LISTEN", value_name = "ADDRESS:PORT")]
    pub listen: Option<String>,

    #[command(flatten)]
    pub log: Log,
}
