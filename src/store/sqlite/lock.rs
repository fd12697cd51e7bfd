//! The names of the files of a data directory, and the lock that says that a process has it.

use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::store::OpenError;

/// Longest time to wait for the lock of a directory, and the pause between two tries.
const LOCK_TIME: Duration = Duration::from_millis(500);
const LOCK_PAUSE: Duration = Duration::from_millis(20);

/// The file whose lock says that a data directory is in use.
pub fn lock_file(data: &Path) -> PathBuf {
    data.join("lock")
}

/// The file of the database.
pub fn database_file(data: &Path) -> PathBuf {
    data.join("graspd.db")
}

/// Whether a process holds the lock of the data directory. Changes nothing.
pub fn is_in_use(data: &Path) -> io::Result<bool> {
    let file = match File::open(lock_file(data)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        file => file?,
    };
    match file.try_lock_shared() {
        Ok(()) => Ok(false),
        Err(TryLockError::WouldBlock) => Ok(true),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// Takes the lock of a data directory for as long as the file is open. Blocks for half a second at most: a command
/// may have it for a moment.
pub fn lock(data: &Path) -> Result<File, OpenError> {
    let unusable = |source| OpenError::Directory {
        path: data.to_owned(),
        source,
    };
    let file = File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(lock_file(data))
        .map_err(unusable)?;
    let begun = Instant::now();
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(file),
            Err(TryLockError::WouldBlock) if begun.elapsed() < LOCK_TIME => {
                std::thread::sleep(LOCK_PAUSE);
            }
            Err(TryLockError::WouldBlock) => return Err(OpenError::InUse(data.to_owned())),
            Err(TryLockError::Error(source)) => return Err(unusable(source)),
        }
    }
}
