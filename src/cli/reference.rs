//! `graspd reference`: writes the reference of all settings, and the definitions that the page uses. Both files are kept
//! in the repository.

use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Arg, Args, Command};

use crate::config::{Config, WorkerConfig};
use crate::wire::settings::reference;

/// Flags of `graspd reference`.
#[derive(Args)]
pub struct Reference {
    /// Folder of the repository
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    repository: PathBuf,
}

/// The file of the reference in the repository.
const PAGE: &str = "docs/settings.md";
/// The file with the definitions that the page uses.
const DATA: &str = "web/src/settings.json";

const INTRODUCTION: &str = "\
<!-- Written by `cargo run -- reference` from the definitions of the settings: do not edit. -->

# Settings

## Of a job

Every setting is a form field, a member of the JSON body, and a flag of `graspd plan` (with `-` for `_`). The job
echoes all of them with the defaults filled in. Those from `contact_model` to `units` and from `robustness` to `gravity`
are settings and flags of an evaluation too.

[Constraints](constraints.md), [candidates](meshes.md#candidates), [the search](search.md),
[priorities](service.md#the-order-of-jobs) and [webhooks](service.md#webhooks) are explained on pages of their own.

";

impl Reference {
    /// Writes both files.
    pub fn run(self) -> ExitCode {
        let data = match reference::json() {
            Ok(data) => data,
            Err(fault) => return super::fail(fault),
        };
        for (file, text) in [(PAGE, page()), (DATA, data)] {
            let path = self.repository.join(file);
            if let Err(fault) = std::fs::write(&path, text) {
                return super::fail(format_args!("cannot write {}: {fault}", path.display()));
            }
        }
        ExitCode::SUCCESS
    }
}

/// The page of the reference.
fn page() -> String {
    let mut page = INTRODUCTION.to_owned() + &reference::markdown();
    page.push_str("\n## Of the server\n\nA flag of `graspd serve` overrides the environment.\n\n");
    write_flags::<Config>(&mut page);
    page.push_str("\n## Of a worker\n\n`graspd worker` takes these; all but `--store` as the server does.\n\n");
    write_flags::<WorkerConfig>(&mut page);
    page
}

fn write_flags<T: Args>(page: &mut String) {
    page.push_str("| flag | environment | default | meaning |\n|---|---|---|---|\n");
    let command = T::augment_args(Command::new("settings"));
    for arg in command.get_arguments() {
        write_flag(arg, page);
    }
}

fn write_flag(arg: &Arg, page: &mut String) {
    let name = arg.get_long().unwrap_or_default();
    let environment = arg
        .get_env()
        .map(|name| name.to_string_lossy().into_owned());
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    // A default that depends on other settings is part of the help text.
    let (help, in_words) = match help.split_once(" [default: ") {
        Some((help, default)) => (help.to_owned(), default.trim_end_matches(']').to_owned()),
        None => (help, String::new()),
    };
    let defaults = arg.get_default_values().iter();
    let defaults: Vec<_> = defaults
        .map(|value| value.to_string_lossy().into_owned())
        .collect();
    let default = match defaults.concat() {
        none if none.is_empty() && in_words.is_empty() => "none".to_owned(),
        none if none.is_empty() => in_words,
        value => format!("`{value}`"),
    };
    let values = arg.get_possible_values();
    let values: Vec<String> = values
        .iter()
        .map(|value| format!("`{}`", value.get_name()))
        .collect();
    let values = match values.is_empty() {
        true => String::new(),
        false => format!(": {}", values.join(" or ")),
    };
    let environment = environment.unwrap_or_default();
    let help = help
        .replace('|', "\\|")
        .replace('<', "\\<")
        .replace('*', "\\*");
    let _ = writeln!(
        page,
        "| `--{name}` | `{environment}` | {default} | {help}{values} |"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_in_the_repository_is_up_to_date() {
        let repository = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
        for (file, text) in [(PAGE, page()), (DATA, reference::json().unwrap())] {
            let kept = std::fs::read_to_string(repository.join(file)).unwrap_or_default();
            assert!(
                kept == text,
                "{file} is stale: run `cargo run -- reference`"
            );
        }
    }
}
