//! `graspd batch`: plans many meshes on a server and writes one file each; an interrupted run can be resumed.
//!
//! Each mesh is submitted on its own under an `Idempotency-Key`, not as part of a batch on the server. A mesh that cannot be
//! used therefore stops none of the others, the queue of the server may be shorter than the list of files, and it is known
//! of each mesh whether the server has accepted it.

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
use std::time::Duration;

use clap::Args;
use parking_lot::Mutex;
use serde_json::{Value, json};
use tokio::signal::unix::{SignalKind, signal};
use url::Url;

use super::exit::{EXIT_INPUT, EXIT_USAGE};
use super::mesh::FileOptions;
use super::settings::{Settings, report_faults};
use error::BatchError;
use folder::Folder;
use journal::{Journal, Opened};
use report::Board;
use server::Server;
use work::{Item, Run};

/// The code that shells use for a command that Ctrl-C has ended.
const EXIT_INTERRUPTED: u8 = 130;

/// Flags of `graspd batch`.
#[derive(Args)]
#[command(
    after_help = "The result of a/duck.stl is written to duck.stl.json in the folder of --output; the second duck.stl \
    among the files to duck.stl-2.json, and so on. summary.csv lists the files and their results.\n\n\
    Ctrl-C stops the command at once; jobs that were sent continue on the server. To resume, run the same \
    command again. Each mesh is planned once, provided that the server still keeps its job, or that a \
    submission without an answer is repeated within 24 hours. More files may be added; other settings need \
    another folder.\n\n\
    Exit codes: 0 a force-closure grasp was found for each mesh; 1 a mesh could not be planned, a file cannot \
    be read or written, or the server refuses requests or cannot be reached; 2 a flag cannot be used, or the \
    folder belongs to other settings; 3 for some mesh no force-closure grasp was found; 130 interrupted."
)]
pub struct Batch {
    /// Mesh files: STL, OBJ, PLY, OFF, GLB, glTF, 3MF or COLLADA
    #[arg(required = true, value_name = "FILES")]
    files: Vec<PathBuf>,

    /// URL of the server, such as http://localhost:8080
    #[arg(long, value_name = "URL", env = "GRASPD_SERVER", value_parser = address)]
    server: Url,

    /// API key, if the server requires one
    #[arg(long, value_name = "KEY", env = "GRASPD_KEY", hide_env_values = true)]
    key: Option<String>,

    /// Folder of the results, created if necessary
    #[arg(long, value_name = "FOLDER", default_value = "graspd-batch")]
    output: PathBuf,

    /// Number of jobs on the server at a time
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
        false => Err("must be a URL that begins with http:// or https://".to_owned()),
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
    /// Plans all meshes, writes the results and returns the exit code.
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
        let code = runtime.block_on(self.execute(settings));
        // Do not wait for files that are still being read.
        runtime.shutdown_background();
        code
    }

    /// The settings of each job, except its label. A seed that was not given is left out, so that the server derives it
    /// from the key of the submission.
    fn settings(&self) -> Result<Value, ExitCode> {
        let usage = |faults: Vec<_>| {
            report_faults(&faults);
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

    async fn execute(self, settings: Value) -> ExitCode {
        let folder = match Folder::open(&self.output) {
            Ok(folder) => folder,
            Err(fault) => return cannot_write(&self.output, &fault),
        };
        let mut journal = match Journal::open(&folder, &settings) {
            Ok(Opened::Ready(journal)) => journal,
            Ok(Opened::InUse) => {
                return super::fail(format_args!(
                    "another graspd batch is running in {}; wait for its end, or give another --output",
                    self.output.display()
                ));
            }
            Ok(Opened::OtherSettings(differences)) => {
                super::print_error(format_args!(
                    "graspd: {} belongs to a batch with other settings ({differences}); use the same settings to \
                     resume it, or another --output",
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
        let work = work::plan_all(&run, items, self.in_flight.get().into(), &board);
        let ended = tokio::select! {
            ended = work => ended,
            () = interruption() => Err(BatchError::Interrupted),
        };
        board.close();
        let advice =
            "the same command resumes from here; jobs that were sent continue on the server";
        match ended {
            Ok(rows) => {
                if let Err(fault) = run
                    .folder
                    .write(report::SUMMARY, report::csv(&rows).as_bytes())
                {
                    return cannot_write(&self.output, &fault);
                }
                let printed = super::print_line(report::table(&rows).trim_end());
                match report::exit_code(&rows) {
                    0 => printed,
                    code => ExitCode::from(code),
                }
            }
            Err(BatchError::Interrupted) => {
                super::print_error(format_args!(
                    "graspd: interrupted, {}; {advice}",
                    board.summary()
                ));
                ExitCode::from(EXIT_INTERRUPTED)
            }
            Err(BatchError::Refused(why)) => {
                super::print_error(format_args!("graspd: {why}; {}; {advice}", board.summary()));
                ExitCode::from(EXIT_INPUT)
            }
            Err(BatchError::Unwritable(fault)) => cannot_write(&self.output, &fault),
        }
    }

    /// The files without duplicates, with the names of their results.
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
