//! What is logged, and how.

use clap::{Args, ValueEnum};

/// The log on standard error.
#[derive(Debug, Clone, Args)]
pub struct Log {
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
