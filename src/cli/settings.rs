//! The settings of a planning request as flags, made from the same definitions as form fields.

use std::fs::File;
use std::io::{self, Read};

use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches};
use serde_json::{Map, Value};

use crate::wire::settings::{
    MAX_DOCUMENT_BYTES, SETTINGS, Scope, Setting, fault, flag_help, object_of_form,
};
use crate::wire::{FieldError, PlanRequest, random_seed};

/// The planning flags that were given, as field name and text.
#[derive(Clone)]
pub struct Settings(Vec<(String, String)>);

impl Settings {
    /// Whether a field was given.
    pub fn is_given(&self, name: &str) -> bool {
        self.0.iter().any(|(given, _)| given == name)
    }

    /// Parses the flags into a request.
    pub fn request(self) -> Result<PlanRequest, Vec<FieldError>> {
        let fields = with_documents(self.0).map_err(|fault| vec![fault])?;
        PlanRequest::from_form(fields, random_seed())
    }
}

/// Replaces file names by the text of the files: a flag that takes a JSON document may name a file.
fn with_documents(mut fields: Vec<(String, String)>) -> Result<Vec<(String, String)>, FieldError> {
    for (name, text) in &mut fields {
        let setting = SETTINGS.iter().find(|setting| setting.name == name);
        let is_document = setting.is_some_and(Setting::is_document);
        if is_document && !text.trim_start().starts_with(['{', '[']) {
            *text = read_document(text).map_err(|error| {
                fault(format!("/{name}"), format!("cannot read {text}: {error}"))
            })?;
        }
    }
    Ok(fields)
}

/// Reads a file, up to just beyond the largest document that is accepted.
fn read_document(path: &str) -> io::Result<String> {
    let mut text = String::new();
    let limit = MAX_DOCUMENT_BYTES as u64 + 1;
    File::open(path)?.take(limit).read_to_string(&mut text)?;
    Ok(text)
}

/// The flags of an evaluation that were given, as field name and text.
#[derive(Clone)]
pub struct QualityFlags(Vec<(String, String)>);

impl QualityFlags {
    /// Converts the flags to a JSON object.
    pub fn object(&self) -> Result<Map<String, Value>, FieldError> {
        let fields = with_documents(self.0.clone())?;
        object_of_form(SETTINGS.iter(), fields, MAX_DOCUMENT_BYTES, &mut Vec::new())
    }
}

/// Returns the name of the flag of a field.
pub fn flag(field: &str) -> String {
    field.replace('_', "-")
}

/// Prints the faults, each with the flag that its field came from.
pub fn report_faults(faults: &[FieldError]) {
    for fault in faults {
        let pointer = fault.pointer.trim_start_matches('/');
        let (name, member) = pointer
            .find('/')
            .map_or((pointer, ""), |at| pointer.split_at(at));
        let space = if member.is_empty() { "" } else { " " };
        super::print_error(format_args!(
            "graspd: --{}{space}{member}: {}",
            flag(name),
            fault.detail
        ));
    }
}

impl Args for Settings {
    fn augment_args(command: Command) -> Command {
        flags(command, "Planning", is_of_run)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Settings {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        Ok(Self(given(matches, is_of_run)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for QualityFlags {
    fn augment_args(command: Command) -> Command {
        flags(command, "Quality", is_of_evaluation)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for QualityFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        Ok(Self(given(matches, is_of_evaluation)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn is_of_run(scope: Scope) -> bool {
    scope != Scope::Job
}

fn is_of_evaluation(scope: Scope) -> bool {
    matches!(scope, Scope::Quality | Scope::Analysis)
}

fn flags(command: Command, heading: &'static str, includes: fn(Scope) -> bool) -> Command {
    let settings = SETTINGS.iter().filter(|setting| includes(setting.scope));
    settings.fold(command, |command, setting| {
        command.arg(
            Arg::new(setting.name)
                .long(flag(setting.name))
                .value_name("VALUE")
                .allow_hyphen_values(true)
                .help_heading(heading)
                .help(flag_help(setting)),
        )
    })
}

fn given(matches: &ArgMatches, includes: fn(Scope) -> bool) -> Vec<(String, String)> {
    let settings = SETTINGS.iter().filter(|setting| includes(setting.scope));
    settings
        .filter_map(|setting| {
            let text = matches.get_one::<String>(setting.name)?;
            Some((setting.name.to_owned(), text.clone()))
        })
        .collect()
}
