//! `graspd batch`: many meshes planned by a server, one file each, as often interrupted as may be.
//!
//! Each mesh is a submission of its own under an `Idempotency-Key`, not one line of a batch on the server: what
//! cannot be used stops nothing else, the queue of the server may be shorter than the list of files, and whether
//! a mesh was taken is known of each alone.

mod error;
mod folder;
mod journal;
mod report;
mod server;
mod work;

use std::collections::HashSet;
use std::io;
use std::num::NonZeroU16;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::Duration;

use clap::Args;
use serde_json::{Value, json};
use tokio::signal::unix::{SignalKind, signal};
use url::Url;

use super::exit::{EXIT_INPUT, EXIT_USAGE};
use super::mesh::FileOptions;
use super::settings::{Settings, tell_faults};
use error::BatchError;
use folder::Folder;
use journal::{Journal, Opened};
use report::Board;
use server::Server;
use work::{Item, Run};

/// As a shell has it for what Ctrl-C has ended.
const EXIT_INTERRUPTED: u8 = 130;

/// Flags of `graspd batch`.
#[derive(Args)]
#[command(
    after_help = "The result of a/duck.stl is written to duck.stl.json in the folder of --output; the second duck.stl \
    among the files to duck.stl-2.json, and so on. summary.csv tells of all of them which is which.\n\n\
    Ctrl-C stops at once, the jobs go on on the server. The same command again goes on where it stopped, \
    however it was stopped: each mesh is planned once, as long as the server keeps its jobs and for 24 hours \
    those that it has just been sent. More files may be added; other settings want another folder.\n\n\
    Exit codes: 0 a force-closure grasp was found for each mesh; 1 some mesh could not be planned, a file cannot \
    be read or written, or the server refuses or is out of reach; 2 a flag cannot be used, or the folder \
    belongs to other settings; 3 some mesh has no force-closure grasp; 130 interrupted."
)]
pub struct Batch {
    /// Mesh files: STL, OBJ, PLY, OFF, GLB or glTF
    #[arg(required = true, value_name = "FILES")]
    files: Vec<PathBuf>,

    /// Address of the server, such as http://localhost:8080
    #[arg(long, value_name = "URL", env = "GRASPD_SERVER", value_parser = address)]
    server: Url,

    /// API key, where the server asks for one
    #[arg(long, value_name = "KEY", env = "GRASPD_KEY", hide_env_values = true)]
    key: Option<String>,

    /// Folder of the results; created when missing
    #[arg(long, value_name = "FOLDER", default_value = "graspd-batch")]
    output: PathBuf,

    /// Jobs that are on the server at a time
    #[arg(long, value_name = "COUNT", default_value = "16", value_parser = in_flight)]
    in_flight: NonZeroU16,

    /// Give up when the server has not answered for so many seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 600)]
    patience: u32,

    #[command(flatten)]
    mesh: FileOptions,

    #[command(flatten)]
    settings: Settings,
}

fn address(text: &str) -> Result<Url, String> {
    let url = Url::parse(text).map_err(|fault| fault.to_string())?;
    match matches!(url.scheme(), "http" | "https") && url.has_host() {
        true => Ok(url),
        false => Err("must be an address that begins with http:// or https://".to_owned()),
    }
}

fn in_flight(text: &str) -> Result<NonZeroU16, String> {
    let count = text
        .parse()
        .ok()
        .filter(|count: &NonZeroU16| count.get() <= 256);
    count.ok_or_else(|| "must be a whole number from 1 to 256".to_owned())
}

impl Batch {
    /// Plans and writes.
    pub fn run(self) -> ExitCode {
        let settings = match self.settings() {
            Ok(settings) => settings,
            Err(code) => return code,
        };
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build();
        let runtime = match runtime {
            Ok(runtime) => runtime,
            Err(fault) => return super::fail(format_args!("cannot start: {fault}")),
        };
        let code = runtime.block_on(self.carry_out(settings));
        // Nothing is waited for that is still read.
        runtime.shutdown_background();
        code
    }

    /// What each job is sent with, all of it but its label; without a seed that was not given, which the server
    /// then makes of the key of the submission.
    fn settings(&self) -> Result<Value, ExitCode> {
        let usage = |faults: Vec<_>| {
            tell_faults(&faults);
            ExitCode::from(EXIT_USAGE)
        };
        let has_seed = self.settings.is_given("seed");
        let request = self.settings.clone().request().map_err(usage)?;
        let mut settings = json!(request);
        settings["priority"] = "batch".into();
        settings["scale"] = self.mesh.scale.into();
        if let Some(format) = self.mesh.format {
            settings["format"] = format.name().into();
        }
        if !has_seed && let Value::Object(settings) = &mut settings {
            settings.remove("seed");
        }
        Ok(settings)
    }

    async fn carry_out(self, settings: Value) -> ExitCode {
        let folder = match Folder::open(&self.output) {
            Ok(folder) => folder,
            Err(fault) => return cannot_write(&self.output, &fault),
        };
        let mut journal = match Journal::open(&folder, &settings) {
            Ok(Opened::Ready(journal)) => journal,
            Ok(Opened::InUse) => {
                return super::fail(format_args!(
                    "another graspd batch is at work in {}; wait for its end, or give this one another --output",
                    self.output.display()
                ));
            }
            Ok(Opened::OtherSettings(differences)) => {
                super::complain(format_args!(
                    "graspd: {} belongs to a batch with other settings ({differences}); give the same ones to go on \
                     with it, or another --output",
                    self.output.display()
                ));
                return ExitCode::from(EXIT_USAGE);
            }
            Err(fault) => return cannot_write(&self.output, &fault),
        };
        let items = match self.items(&mut journal) {
            Ok(items) => items,
            Err(fault) => return cannot_write(&self.output, &fault),
        };
        let patience = Duration::from_secs(self.patience.into());
        let board = Board::new(items.len());
        let server = match Server::new(&self.server, self.key.as_deref(), patience, board.clone()) {
            Ok(server) => server,
            Err(fault) => return super::fail(fault),
        };
        let run = Run {
            folder,
            journal: Mutex::new(journal),
            server,
            settings,
        };
        let work = work::all(&run, items, self.in_flight.get().into(), &board);
        let ended = tokio::select! {
            ended = work => ended,
            () = interruption() => Err(BatchError::Interrupted),
        };
        board.close();
        let again = "the same command goes on from here; jobs that were sent go on on the server";
        match ended {
            Ok(rows) => {
                if let Err(fault) = run
                    .folder
                    .write(report::SUMMARY, report::csv(&rows).as_bytes())
                {
                    return cannot_write(&self.output, &fault);
                }
                let printed = super::say(report::table(&rows).trim_end());
                match report::worst(&rows) {
                    0 => printed,
                    code => ExitCode::from(code),
                }
            }
            Err(BatchError::Interrupted) => {
                super::complain(format_args!(
                    "graspd: interrupted, {}; {again}",
                    board.standing()
                ));
                ExitCode::from(EXIT_INTERRUPTED)
            }
            Err(BatchError::Refused(why)) => {
                super::complain(format_args!("graspd: {why}; {}; {again}", board.standing()));
                ExitCode::from(EXIT_INPUT)
            }
            Err(BatchError::Unwritable(fault)) => cannot_write(&self.output, &fault),
        }
    }

    /// The files, each once, with the names of their results.
    fn items(&self, journal: &mut Journal) -> io::Result<Vec<Item>> {
        let (mut given, mut paths) = (Vec::new(), Vec::new());
        let mut seen = HashSet::new();
        for file in &self.files {
            let path = std::path::absolute(file)?;
            let path = path.to_str().map(str::to_owned);
            let path = path.ok_or_else(|| {
                io::Error::other(format!("the path of {} is not UTF-8", file.display()))
            })?;
            if seen.insert(path.clone()) {
                given.push(file.display().to_string());
                paths.push(path);
            }
        }
        let outputs = journal.name(&paths)?;
        let items = given.into_iter().zip(paths).zip(outputs);
        let items = items.map(|((file, path), output)| Item { file, path, output });
        Ok(items.collect())
    }
}

/// Waits for Ctrl-C, or for SIGTERM.
async fn interruption() {
    let terminated = async {
        match signal(SignalKind::terminate()) {
            Ok(mut signal) => drop(signal.recv().await),
            Err(_) => std::future::pending().await,
        }
    };
    tokio::select! {
        _ = tokio::signal::ctrl_c() => {}
        () = terminated => {}
    }
}

fn cannot_write(folder: &std::path::Path, fault: &std::io::Error) -> ExitCode {
    super::fail(format_args!(
        "the folder {} cannot be used: {fault}",
        folder.display()
    ))
}
