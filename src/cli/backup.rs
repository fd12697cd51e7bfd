//! `graspd backup` and `graspd restore`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use crate::store::sqlite::{BackupError, Contents, back_up, restore};

/// Flags of `graspd backup`.
#[derive(Args)]
#[command(
    after_help = "A server may run on the data directory. With exit code 0 the backup is complete, verified and on \
    stable storage; with any other code it leaves no files behind.\n\n\
    Exit codes: 0 backed up; 1 failed, with the reason; 2 a flag cannot be used."
)]
pub struct Backup {
    /// Folder of the database and the meshes
    #[arg(
        long,
        env = "GRASPD_DATA_DIR",
        value_name = "FOLDER",
        default_value = "./graspd-data"
    )]
    data_dir: PathBuf,

    /// Folder of the backup, which must not exist yet
    #[arg(value_name = "TARGET")]
    target: PathBuf,
}

/// Flags of `graspd restore`.
#[derive(Args)]
#[command(
    after_help = "Exit codes: 0 restored and verified; 1 failed, with the reason; 2 a flag cannot be used."
)]
pub struct Restore {
    /// Folder that `graspd backup` has written
    #[arg(value_name = "BACKUP")]
    backup: PathBuf,

    /// Folder to restore into; it must be missing or empty
    #[arg(
        long,
        env = "GRASPD_DATA_DIR",
        value_name = "FOLDER",
        default_value = "./graspd-data"
    )]
    data_dir: PathBuf,
}

impl Backup {
    /// Copies a data directory and returns the exit code.
    pub fn run(self) -> ExitCode {
        let Self { data_dir, target } = self;
        let name = target.display().to_string();
        report("backed up", &name, async move {
            back_up(&data_dir, &target).await
        })
    }
}

impl Restore {
    /// Restores a backup and returns the exit code.
    pub fn run(self) -> ExitCode {
        let Self { backup, data_dir } = self;
        let name = data_dir.display().to_string();
        report("restored", &name, async move {
            restore(&backup, &data_dir).await
        })
    }
}

/// Runs `work` and prints how much it copied, or why it failed.
fn report(
    done: &str,
    target: &str,
    work: impl Future<Output = Result<Contents, BackupError>>,
) -> ExitCode {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let outcome = match runtime {
        Ok(runtime) => runtime.block_on(work),
        Err(fault) => return super::fail(fault),
    };
    match outcome {
        Ok(Contents { jobs, meshes }) => super::print_line(format_args!(
            "{done} {jobs} jobs and {meshes} meshes to {target}"
        )),
        Err(fault) => super::fail(fault),
    }
}
