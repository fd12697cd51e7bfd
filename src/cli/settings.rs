//! The fields of a planning request as flags, from the same table that forms are read by.

use std::fs::File;
use std::io::{self, Read};

use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches};

use crate::wire::{
    ANALYSIS_FIELDS, FIELDS, FieldError, JOB_FIELDS, MAX_CONSTRAINTS_BYTES, PlanRequest,
    QUALITY_FIELDS, random_seed,
};

/// The planning flags that were given, as field name and text.
#[derive(Clone)]
pub struct Settings(Vec<(String, String)>);

impl Settings {
    /// Whether a field was given.
    pub fn is_given(&self, name: &str) -> bool {
        self.0.iter().any(|(given, _)| given == name)
    }

    /// The effective request. A flag that is a JSON document may name the file that holds it.
    pub fn request(self) -> Result<PlanRequest, Vec<FieldError>> {
        let mut fields = self.0;
        let is_json = |name: &str| FIELDS.iter().any(|f| f.name == name && f.is_json());
        for (name, text) in &mut fields {
            if is_json(name) && !text.trim_start().starts_with(['{', '[']) {
                *text = read_document(text).map_err(|fault| {
                    vec![FieldError {
                        pointer: format!("/{name}"),
                        detail: format!("cannot read {text}: {fault}"),
                    }]
                })?;
            }
        }
        PlanRequest::from_form(fields, random_seed())
    }
}

/// A file's text, as far as it is worth reading.
fn read_document(path: &str) -> io::Result<String> {
    let mut text = String::new();
    let limit = MAX_CONSTRAINTS_BYTES as u64 + 1;
    File::open(path)?.take(limit).read_to_string(&mut text)?;
    Ok(text)
}

/// The flags of an evaluation that were given, as field name and text.
#[derive(Clone)]
pub struct QualityFlags(pub Vec<(String, String)>);

/// The flag of a field.
pub fn flag(field: &str) -> String {
    field.replace('_', "-")
}

/// Says what is wrong with the flags that fields came from.
pub fn tell_faults(faults: &[FieldError]) {
    for fault in faults {
        let pointer = fault.pointer.trim_start_matches('/');
        let (name, member) = pointer
            .find('/')
            .map_or((pointer, ""), |at| pointer.split_at(at));
        let space = if member.is_empty() { "" } else { " " };
        super::complain(format_args!(
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

fn is_of_run(name: &str) -> bool {
    !JOB_FIELDS.contains(&name)
}

fn is_of_evaluation(name: &str) -> bool {
    QUALITY_FIELDS.contains(&name) || ANALYSIS_FIELDS.contains(&name)
}

fn flags(command: Command, heading: &'static str, wanted: fn(&str) -> bool) -> Command {
    let fields = FIELDS.iter().filter(|field| wanted(field.name));
    fields.fold(command, |command, field| {
        command.arg(
            Arg::new(field.name)
                .long(flag(field.name))
                .value_name("VALUE")
                .allow_hyphen_values(true)
                .help_heading(heading)
                .help(field.help),
        )
    })
}

fn given(matches: &ArgMatches, wanted: fn(&str) -> bool) -> Vec<(String, String)> {
    let fields = FIELDS.iter().filter(|field| wanted(field.name));
    fields
        .filter_map(|field| {
            let text = matches.get_one::<String>(field.name)?;
            Some((field.name.to_owned(), text.clone()))
        })
        .collect()
}
