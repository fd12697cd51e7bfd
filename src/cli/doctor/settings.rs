//! The settings in effect and where they come from.

use std::collections::HashSet;

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command};
use serde::Serialize;

use super::Finding;
use crate::config::Config;

/// A setting with its effective value.
#[derive(Debug, Serialize)]
pub struct Setting {
    pub flag: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    environment: Option<String>,
    /// The value as given; secrets are hidden.
    pub value: Option<String>,
    /// `flag`, `environment` or `default`.
    pub source: &'static str,
}

/// Every setting of the server, with its value in `matches`.
pub fn effective(matches: &ArgMatches) -> Vec<Setting> {
    let command = Config::augment_args(Command::new("serve"));
    let setting = |argument: &Arg| {
        let id = argument.get_id().as_str();
        let source = match matches.value_source(id) {
            Some(ValueSource::CommandLine) => "flag",
            Some(ValueSource::EnvVariable) => "environment",
            _ => "default",
        };
        let values = matches.get_raw(id).map(|values| {
            let values: Vec<_> = values.map(|value| value.to_string_lossy()).collect();
            shown(argument, &values.join(","))
        });
        Setting {
            flag: format!("--{}", argument.get_long().unwrap_or(id)),
            environment: environment(argument),
            value: values,
            source,
        }
    };
    command.get_arguments().map(setting).collect()
}

/// Reports environment variables that look like settings but are not, such as misspelt ones.
pub fn unknown() -> Option<Finding> {
    let command = Config::augment_args(Command::new("serve"));
    let known: HashSet<String> = command.get_arguments().filter_map(environment).collect();
    let names = std::env::vars_os().filter_map(|(name, _)| name.into_string().ok());
    let mut odd: Vec<String> = names
        .filter(|name| name.starts_with("GRASPD_") && !known.contains(name))
        .collect();
    odd.sort();
    (!odd.is_empty()).then(|| {
        Finding::warning(
            "environment",
            format_args!("{} is not a setting", odd.join(", ")),
            "correct the spelling, or remove it; graspd serve --help lists all",
        )
    })
}

fn environment(argument: &Arg) -> Option<String> {
    Some(argument.get_env()?.to_string_lossy().into_owned())
}

fn shown(argument: &Arg, value: &str) -> String {
    let id = argument.get_id().as_str();
    let named = ["secret", "token", "password"];
    if argument.is_hide_env_values_set() || named.iter().any(|name| id.contains(name)) {
        return "(hidden)".to_owned();
    }
    // Hide the user and password of a URL.
    match value.split_once("://").zip(value.rsplit_once('@')) {
        Some(((scheme, _), (_, host))) => format!("{scheme}://(hidden)@{host}"),
        None => value.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secrets_are_not_shown() {
        let plain = Arg::new("listen");
        assert_eq!(shown(&plain, "127.0.0.1:0"), "127.0.0.1:0");
        assert_eq!(
            shown(&plain, "postgres://me:pass@host/base"),
            "postgres://(hidden)@host/base"
        );
        assert_eq!(shown(&Arg::new("webhook_secret"), "abc"), "(hidden)");
        assert_eq!(
            shown(&Arg::new("x").hide_env_values(true), "abc"),
            "(hidden)"
        );
    }
}
