//! Backup and restore: a data directory copied while a server runs on it, and put back.
//!
//! A backup is itself a data directory: `graspd.db` and `meshes/`. It appears under its name only
//! once it is whole, verified and on stable storage.

use std::collections::HashSet;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use sqlx::ConnectOptions;
use sqlx::sqlite::SqliteConnectOptions;
use tempfile::TempDir;

use super::files::{Files, sync_folder};
use super::lock::{database_file, is_in_use, lock_file};
use super::survey::Survey;
use super::{VERSION, now};
use crate::store::StoreError;
use crate::store::leases::UNSEEN_REVISIONS;
use crate::wire::MeshId;

/// How much was copied.
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
/// Everything acknowledged before the call is in it. Jobs that run are copied as queued, or as cancelled
/// where that was asked for. Reads every mesh file once.
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
        let database = database_file(copy.path());
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
    if is_in_use(backup).unwrap_or(true) {
        return Err(BackupError::NotEmpty(backup.to_owned()));
    }
    let Some(empty) = Empty::take(data)? else {
        verify(backup).await?;
        let copy = beside(data)?;
        fill(backup, copy.path())?;
        return finish(copy, data).await;
    };
    verify(backup).await?;
    let copy = unfinished(data)?;
    fill(backup, copy.path())?;
    let contents = secure(copy.path()).await?;
    let failed = |source| BackupError::File {
        path: data.to_owned(),
        source,
    };
    empty.receive(copy.path()).map_err(failed)?;
    Ok(contents)
}

/// Copies the files of a backup that no server uses.
fn fill(backup: &Path, folder: &Path) -> Result<(), StoreError> {
    fs::create_dir(folder.join("meshes"))?;
    let (from, to) = (Files::at(backup), Files::at(folder));
    for id in from.list()? {
        keep(&from, &to, &id, |from, to| fs::copy(from, to).map(drop))?;
    }
    fs::copy(database_file(backup), database_file(folder))?;
    Ok(())
}

/// A folder with nothing in it, such as a mount point, which cannot be renamed over. No server starts on it
/// while this is held; it is left as it was found unless it receives a copy.
struct Empty<'a> {
    data: &'a Path,
    _lock: File,
    is_filled: bool,
}

impl<'a> Empty<'a> {
    /// `None` where there is no such folder.
    fn take(data: &'a Path) -> Result<Option<Self>, BackupError> {
        let failed = |source| BackupError::File {
            path: data.to_owned(),
            source,
        };
        let entries = match fs::read_dir(data) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            entries => entries.map_err(failed)?,
        };
        for entry in entries {
            // A file system of its own may have this at its root.
            if entry.map_err(failed)?.file_name() != "lost+found" {
                return Err(BackupError::NotEmpty(data.to_owned()));
            }
        }
        let lock = File::create_new(lock_file(data)).map_err(failed)?;
        match lock.try_lock() {
            Ok(()) => Ok(Some(Self {
                data,
                _lock: lock,
                is_filled: false,
            })),
            Err(TryLockError::WouldBlock) => Err(BackupError::NotEmpty(data.to_owned())),
            Err(TryLockError::Error(source)) => Err(failed(source)),
        }
    }

    /// Moves in the files of `copy`, the database last: without it the folder does not count as a data directory.
    fn receive(mut self, copy: &Path) -> io::Result<()> {
        fs::rename(copy.join("meshes"), self.data.join("meshes"))?;
        fs::rename(database_file(copy), database_file(self.data))?;
        self.is_filled = true;
        sync_folder(self.data)
    }
}

impl Drop for Empty<'_> {
    fn drop(&mut self) {
        if !self.is_filled {
            let _ = fs::remove_dir_all(self.data.join("meshes"));
            let _ = fs::remove_file(lock_file(self.data));
        }
    }
}

/// Makes the rows and files of a copy agree, and leaves nothing running in it.
async fn pair(database: &Path, from: &Files, to: &Files) -> Result<(), StoreError> {
    let options = SqliteConnectOptions::new().filename(database);
    let mut copy = options.connect().await?;
    // As when a server stops in good order: the attempt does not count.
    sqlx::query(
        "UPDATE jobs SET lease = NULL, progress = NULL, revision = revision + ?2, \
         started_at = CASE WHEN cancel_requested THEN started_at END, \
         finished_at = CASE WHEN cancel_requested THEN max(?1, started_at) END, \
         state = CASE WHEN cancel_requested THEN 'cancelled' ELSE 'queued' END \
         WHERE state = 'running'",
    )
    .bind(now())
    .bind(UNSEEN_REVISIONS)
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
    let contents = secure(copy.path()).await?;
    let failed = |source| BackupError::File {
        path: target.to_owned(),
        source,
    };
    fs::rename(copy.path(), target).map_err(failed)?;
    // It has another name now.
    let _ = copy.keep();
    sync_folder(folder_of(target)).map_err(failed)?;
    Ok(contents)
}

/// Verifies a copy and makes its files safe from a power cut.
async fn secure(copy: &Path) -> Result<Contents, BackupError> {
    let contents = verify(copy).await?;
    let files = Files::at(copy);
    let sync = || -> io::Result<()> {
        for id in files.list()? {
            File::open(files.path(&id))?.sync_all()?;
        }
        File::open(database_file(copy))?.sync_all()?;
        sync_folder(&copy.join("meshes"))?;
        sync_folder(copy)
    };
    sync().map_err(|source| BackupError::File {
        path: copy.to_owned(),
        source,
    })?;
    Ok(contents)
}

/// Checks that a backup is whole: its database, its version, and the bytes of every mesh.
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

/// Opens a data directory, if this program knows its version.
async fn readable(data: &Path) -> Result<Survey, BackupError> {
    let unreadable = |source| BackupError::Unreadable {
        path: data.to_owned(),
        source,
    };
    let mut survey = Survey::open(data).await.map_err(unreadable)?;
    let found = survey.schema_version().await.map_err(unreadable)?;
    let known = VERSION;
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
    unfinished(folder_of(target))
}

fn unfinished(folder: &Path) -> Result<TempDir, BackupError> {
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

/// Puts the file of a mesh into the copy. Returns whether there is one.
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
        // Another file system, or one without hard links.
        Err(_) => fs::copy(from, to).map(drop),
        Ok(()) => Ok(()),
    }
}
