//! `graspd keys`

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Args, Subcommand};
use jiff::Timestamp;

use super::{cannot_print, fail, print_error};
use crate::config::{self, Period, period};
use crate::jobs::Location;
use crate::store::postgres::{PoolSizes, Postgres};
use crate::store::sqlite::SqliteKeys;
use crate::store::{KeyRecord, Keys as Keyring};

const MAX_NAME_CHARS: usize = 100;

/// Creates, lists and revokes API keys; a server may be running.
#[derive(Args)]
pub struct Keys {
    #[command(flatten)]
    store: config::Store,

    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Create a key and print it once; only a hash is stored
    Create {
        /// Name of the key or of its owner, for display
        #[arg(value_name = "NAME", value_parser = name, default_value = "")]
        name: String,

        /// How long the key is valid, such as 90d, or "forever"
        #[arg(long, value_name = "TIME", default_value = "forever", value_parser = period)]
        expires: Period,
    },
    /// List the keys, without their secrets
    List {
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Revoke a key at once; its jobs and meshes stay until they expire
    Revoke {
        /// The id that `list` shows, which is the middle part of the key
        id: String,

        /// Cancel its jobs too, both waiting and running
        #[arg(long)]
        cancel_jobs: bool,
    },
}

impl Keys {
    /// Runs the subcommand and returns the exit code.
    pub fn run(self) -> ExitCode {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build();
        let done = match runtime {
            Ok(runtime) => runtime.block_on(self.execute()),
            Err(fault) => return fail(fault),
        };
        match done {
            Ok(text) => match io::stdout().write_all(text.as_bytes()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(fault) => cannot_print(&fault),
            },
            Err(fault) => fail(fault),
        }
    }

    /// Runs the subcommand and returns the text to print.
    async fn execute(self) -> Result<String, Box<dyn std::error::Error>> {
        let keys: Box<dyn Keyring> = match self.store.location() {
            Location::Folder(data) => Box::new(SqliteKeys::open(&data).await?),
            Location::Database(url) => {
                Box::new(Postgres::open(&url, PoolSizes::of_worker(1)).await?)
            }
        };
        match self.command {
            Command::Create { name, expires } => {
                let expires_at = match expires {
                    Period::For(time) => Some(Timestamp::now().checked_add(time)?),
                    Period::Forever => None,
                };
                let key = keys.create(&name, expires_at).await?;
                print_error(format_args!(
                    "key {} is valid {}; store it now, it is not shown again",
                    key.record.id,
                    expires_at.map_or("until it is revoked".to_owned(), |at| format!(
                        "until {at:.0}"
                    ))
                ));
                Ok(format!("{}\n", key.text))
            }
            Command::List { json: true } => {
                Ok(serde_json::to_string_pretty(&keys.list().await?)? + "\n")
            }
            Command::List { json: false } => Ok(table(&keys.list().await?)),
            Command::Revoke { id, cancel_jobs } => {
                if !keys.revoke(&id).await? {
                    let advice = "graspd keys list shows the ids";
                    return Err(format!("there is no key {id:?}; {advice}").into());
                }
                if !cancel_jobs {
                    return Ok(format!("key {id} is revoked\n"));
                }
                let jobs = keys.cancel_jobs(&id).await?;
                Ok(format!("key {id} is revoked; cancelled jobs: {jobs}\n"))
            }
        }
    }
}

fn name(text: &str) -> Result<String, String> {
    let is_fit = text.chars().count() <= MAX_NAME_CHARS && !text.chars().any(char::is_control);
    match is_fit {
        true => Ok(text.to_owned()),
        false => Err("must have at most 100 characters and no control characters".to_owned()),
    }
}

fn table(keys: &[KeyRecord]) -> String {
    let mut text = format!(
        "{:<12}  {:<20}  {:<20}  {:<20}  {}\n",
        "id", "created", "expires", "revoked", "name"
    );
    for key in keys {
        let moment = |at: Option<Timestamp>| at.map_or("-".to_owned(), |at| format!("{at:.0}"));
        text += &format!(
            "{:<12}  {:<20}  {:<20}  {:<20}  {}\n",
            key.id,
            moment(Some(key.created_at)),
            moment(key.expires_at),
            moment(key.revoked_at),
            key.name
        );
    }
    text
}
