//! Backup and restore: a data directory copied while a server runs on it, and put back.
//!
//! A backup is itself a data directory: `graspd.db` and `meshes/`. It appears under its name only
//! once it is whole, verified and on stable storage.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use sqlx::ConnectOptions;
use sqlx::sqlite::SqliteConnectOptions;
use tempfile::TempDir;

use super::StoreError;
use super::files::{Files, sync_folder};
use super::survey::{self, Survey};
use crate::wire::MeshId;

/// What was copied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contents {
    pub jobs: u64,
    pub meshes: u64,
}

/// Why nothing was copied. What had been begun is removed.
#[derive(Debug, thiserror::Error)]
pub enum BackupError {
    #[error("{} is there already; give a name that is not", .0.display())]
    Exists(PathBuf),
    #[error("{} is in use by a server or not empty; give a folder that is missing or empty", .0.display())]
    NotEmpty(PathBuf),
    #[error("{}: {source}", .path.display())]
    File { path: PathBuf, source: io::Error },
    #[error("{} cannot be read as a data directory of graspd: {source}", .path.display())]
    Unreadable { path: PathBuf, source: StoreError },
    #[error("the copy cannot be made: {0}")]
    Copy(#[from] StoreError),
    #[error("{} is of version {found}, and this program knows versions up to {known}; use a later graspd", .path.display())]
    Newer {
        path: PathBuf,
        found: i64,
        known: i64,
    },
    #[error("{} is damaged: {}", .path.display(), .faults.join("; "))]
    Damaged { path: PathBuf, faults: Vec<String> },
}

/// Copies the data directory `data`, on which a server may run, to `target`, which must not exist.
/// Mesh files, which never change, are hard-linked where that is possible.
///
/// Everything acknowledged before the call is in it. Jobs that run are copied as queued. Reads every
/// mesh file once.
pub async fn back_up(data: &Path, target: &Path) -> Result<Contents, BackupError> {
    if fs::symlink_metadata(target).is_ok() {
        return Err(BackupError::Exists(target.to_owned()));
    }
    let mut source = readable(data).await?;
    let copy = beside(target)?;
    let (from, to) = (Files::at(data), Files::at(copy.path()));
    let made = async {
        fs::create_dir(copy.path().join("meshes"))?;
        // Before the rows are copied: a mesh may be forgotten while this runs.
        for id in from.list()? {
            keep(&from, &to, &id, link)?;
        }
        let database = survey::database(copy.path());
        let name = database.to_str().ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidFilename, "the name is not UTF-8")
        })?;
        sqlx::query("VACUUM INTO ?1")
            .bind(name)
            .execute(&mut source.connection)
            .await?;
        pair(&database, &from, &to).await
    };
    made.await?;
    finish(copy, target).await
}

/// Copies `backup` to `data`, which must be missing or empty. Reads every mesh file twice.
pub async fn restore(backup: &Path, data: &Path) -> Result<Contents, BackupError> {
    let taken = match fs::read_dir(data) {
        Ok(mut entries) => entries.next().is_some(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => false,
        Err(source) => {
            let path = data.to_owned();
            return Err(BackupError::File { path, source });
        }
    };
    if taken {
        return Err(BackupError::NotEmpty(data.to_owned()));
    }
    if survey::is_in_use(backup).unwrap_or(true) {
        return Err(BackupError::NotEmpty(backup.to_owned()));
    }
    verify(backup).await?;
    let copy = beside(data)?;
    let (from, to) = (Files::at(backup), Files::at(copy.path()));
    let made = || -> Result<(), StoreError> {
        fs::create_dir(copy.path().join("meshes"))?;
        for id in from.list()? {
            keep(&from, &to, &id, |from, to| fs::copy(from, to).map(drop))?;
        }
        fs::copy(survey::database(backup), survey::database(copy.path()))?;
        Ok(())
    };
    made()?;
    finish(copy, data).await
}

/// Makes the rows and files of a copy agree, and leaves nothing running in it.
async fn pair(database: &Path, from: &Files, to: &Files) -> Result<(), StoreError> {
    let options = SqliteConnectOptions::new().filename(database);
    let mut copy = options.connect().await?;
    // As when a server stops in good order: the attempt does not count.
    sqlx::query(
        "UPDATE jobs SET state = 'queued', lease = NULL, progress = NULL, started_at = NULL, \
         revision = revision + 1 WHERE state = 'running' AND NOT cancel_requested",
    )
    .execute(&mut copy)
    .await?;
    let rows: Vec<String> = sqlx::query_scalar("SELECT DISTINCT id FROM meshes")
        .fetch_all(&mut copy)
        .await?;
    let rows: HashSet<MeshId> = rows.iter().filter_map(|id| MeshId::parse(id)).collect();
    let linked: HashSet<MeshId> = to.list()?.into_iter().collect();
    for id in linked.difference(&rows) {
        to.remove(id)?;
    }
    for id in rows.difference(&linked) {
        if !keep(from, to, id, link)? {
            // Forgotten since its row was copied; no job that has not ended needs it.
            sqlx::query(
                "DELETE FROM meshes WHERE id = ?1 AND NOT EXISTS (SELECT 1 FROM jobs \
                 WHERE mesh_id = ?1 AND state IN ('queued', 'running'))",
            )
            .bind(id.as_str())
            .execute(&mut copy)
            .await?;
        }
    }
    sqlx::Connection::close(copy).await?;
    Ok(())
}

/// Verifies a copy, makes it safe from a power cut and gives it its name.
async fn finish(copy: TempDir, target: &Path) -> Result<Contents, BackupError> {
    let contents = verify(copy.path()).await?;
    let failed = |source| BackupError::File {
        path: target.to_owned(),
        source,
    };
    let files = Files::at(copy.path());
    let sync = || -> io::Result<()> {
        for id in files.list()? {
            File::open(files.path(&id))?.sync_all()?;
        }
        File::open(survey::database(copy.path()))?.sync_all()?;
        sync_folder(&copy.path().join("meshes"))?;
        sync_folder(copy.path())
    };
    sync().map_err(failed)?;
    fs::rename(copy.path(), target).map_err(failed)?;
    // It has another name now.
    let _ = copy.keep();
    sync_folder(folder_of(target)).map_err(failed)?;
    Ok(contents)
}

/// Whether a backup is whole: database, versions, and the bytes of every mesh.
async fn verify(backup: &Path) -> Result<Contents, BackupError> {
    let mut survey = readable(backup).await?;
    let unreadable = |source| BackupError::Unreadable {
        path: backup.to_owned(),
        source,
    };
    let mut faults = survey.faults(false).await.map_err(unreadable)?;
    faults.extend(survey.damaged_meshes().await.map_err(unreadable)?);
    if !faults.is_empty() {
        let path = backup.to_owned();
        return Err(BackupError::Damaged { path, faults });
    }
    Ok(Contents {
        jobs: survey.jobs().await.map_err(unreadable)?,
        meshes: survey.meshes().await.map_err(unreadable)?.len() as u64,
    })
}

/// A data directory of a version that this program knows.
async fn readable(data: &Path) -> Result<Survey, BackupError> {
    let unreadable = |source| BackupError::Unreadable {
        path: data.to_owned(),
        source,
    };
    let mut survey = Survey::open(data).await.map_err(unreadable)?;
    let found = survey.schema_version().await.map_err(unreadable)?;
    let known = survey::known_schema_version();
    if found > known {
        return Err(BackupError::Newer {
            path: data.to_owned(),
            found,
            known,
        });
    }
    Ok(survey)
}

/// A new folder beside `target`, on the same file system; it is removed unless it is renamed.
fn beside(target: &Path) -> Result<TempDir, BackupError> {
    let folder = folder_of(target);
    tempfile::Builder::new()
        .prefix(".graspd-unfinished-")
        .tempdir_in(folder)
        .map_err(|source| BackupError::File {
            path: folder.to_owned(),
            source,
        })
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Puts the file of a mesh into the copy. Says whether there is one.
fn keep(
    from: &Files,
    to: &Files,
    id: &MeshId,
    put: impl Fn(&Path, &Path) -> io::Result<()>,
) -> io::Result<bool> {
    match put(&from.path(id), &to.path(id)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        outcome => outcome.map(|()| true),
    }
}

fn link(from: &Path, to: &Path) -> io::Result<()> {
    match fs::hard_link(from, to) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Err(error),
        // Another file system, or one that knows no links.
        Err(_) => fs::copy(from, to).map(drop),
        Ok(()) => Ok(()),
    }
}
