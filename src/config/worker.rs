//! The settings of `graspd worker`.

use clap::Args;

use super::{Log, Planning};

/// The settings of a process that only plans.
#[derive(Debug, Clone, Args)]
pub struct WorkerConfig {
    /// The PostgreSQL database of the servers: postgres://USER:PASSWORD@HOST:PORT/DATABASE. Set it in the environment:
    /// other users can see flags
    #[arg(long, env = "GRASPD_STORE", value_name = "URL", hide_env_values = true)]
    pub store: String,

    #[command(flatten)]
    pub planning: Planning,

    /// Address and port on which only /healthz, /readyz and /metrics are answered [default: none]
    #[arg(long, env = "GRASPD_LISTEN", value_name = "ADDRESS:PORT")]
    pub listen: Option<String>,

    #[command(flatten)]
    pub log: Log,
}
