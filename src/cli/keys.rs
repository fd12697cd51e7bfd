//! `graspd keys`

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Args, Subcommand};
use jiff::Timestamp;

use super::{complain, fail, unwritten};
use crate::config::{self, Period, period};
use crate::jobs::Location;
use crate::store::postgres::{PoolSizes, Postgres};
use crate::store::sqlite::SqliteKeys;
use crate::store::{KeyRecord, Keys as Keyring};

const MAX_NAME_CHARS: usize = 100;

/// Makes, lists and revokes API keys, while a server runs or not.
#[derive(Args)]
pub struct Keys {
    #[command(flatten)]
    store: config::Store,

    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Make a key and print it, this once: only a hash is kept
    Create {
        /// Whose it is, for people
        #[arg(value_name = "NAME", value_parser = name, default_value = "")]
        name: String,

        /// How long it is good for, such as 90d, or "forever"
        #[arg(long, value_name = "TIME", default_value = "forever", value_parser = period)]
        expires: Period,
    },
    /// List the keys, without their secrets
    List {
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Make a key worthless, at once; what was sent with it stays until it expires
    Revoke {
        /// The id that `list` shows, the middle part of the key
        id: String,

        /// Cancel its jobs too: those that wait at once, those that run when they end
        #[arg(long)]
        cancel_jobs: bool,
    },
}

impl Keys {
    /// Does what is asked. Code 1 when it cannot be done.
    pub fn run(self) -> ExitCode {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build();
        let done = match runtime {
            Ok(runtime) => runtime.block_on(self.carry_out()),
            Err(fault) => return fail(fault),
        };
        match done {
            Ok(text) => match io::stdout().write_all(text.as_bytes()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(fault) => unwritten(&fault),
            },
            Err(fault) => fail(fault),
        }
    }

    /// What is to be printed.
    async fn carry_out(self) -> Result<String, Box<dyn std::error::Error>> {
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
                complain(format_args!(
                    "key {} is good {}; keep it, it is not shown again",
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
        false => {
            Err("at most 100 characters, none of them a control character, are wanted".to_owned())
        }
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
