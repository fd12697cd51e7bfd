//! The settings of the log.

use clap::{Args, ValueEnum};

/// The log on standard error.
#[derive(Debug, Clone, Args)]
pub struct Log {
    /// Format of the log lines on standard error
    #[arg(
        long,
        env = "GRASPD_LOG_FORMAT",
        value_enum,
        default_value_t = LogFormat::Text
    )]
    pub log_format: LogFormat,

    /// Log level: error, warn, info, debug, trace, or a filter such as info,graspd=debug
    #[arg(
        long,
        env = "GRASPD_LOG_LEVEL",
        value_name = "LEVEL",
        default_value = "info"
    )]
    pub log_level: String,
}

/// The format of log lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// Readable text.
    Text,
    /// One JSON object per line.
    Json,
}
