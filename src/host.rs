//! What the system says of this process and its disks. What it does not say on some system is
//! `None` there.

use std::io;
use std::path::Path;

/// What this process takes now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Usage {
    /// Memory that is in RAM, in bytes.
    pub resident_bytes: u64,
    /// Processor time since the start, in seconds.
    pub cpu_seconds: f64,
    /// Files, sockets and pipes.
    pub open_files: u64,
    pub threads: u64,
}

/// Bytes that an unprivileged process may still write to the file system of `path`.
pub fn free_bytes(path: &Path) -> io::Result<u64> {
    let found = rustix::fs::statvfs(path)?;
    Ok(found.f_bavail.saturating_mul(found.f_frsize))
}

/// Most files that this process may have open once it asks for as many; `None` is no limit.
pub fn open_file_limit() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::Nofile).maximum
}

#[cfg(target_os = "linux")]
pub use linux::{available_memory, file_system, lock_holder, usage};
#[cfg(not(target_os = "linux"))]
pub use other::{available_memory, file_system, lock_holder, usage};

#[cfg(target_os = "linux")]
mod linux {
    use std::os::unix::fs::MetadataExt;
    use std::path::Path;

    use procfs::process::Process;
    use procfs::{Current, WithCurrentSystemInfo};

    use super::Usage;

    /// What this process takes now. Reads a few small files of `/proc`.
    pub fn usage() -> Option<Usage> {
        let process = Process::myself().ok()?;
        let stat = process.stat().ok()?;
        Some(Usage {
            resident_bytes: stat.rss_bytes().get(),
            cpu_seconds: (stat.utime + stat.stime) as f64 / procfs::ticks_per_second() as f64,
            open_files: process.fd_count().ok()? as u64,
            threads: u64::try_from(stat.num_threads).ok()?,
        })
    }

    /// Bytes of memory that can be had without swapping.
    pub fn available_memory() -> Option<u64> {
        procfs::Meminfo::current().ok()?.mem_available
    }

    /// The kind of file system that holds `path`, such as `ext4`.
    pub fn file_system(path: &Path) -> Option<String> {
        let path = path.canonicalize().ok()?;
        let mounts = Process::myself().ok()?.mountinfo().ok()?;
        mounts
            .into_iter()
            .filter(|mount| path.starts_with(&mount.mount_point))
            // Of two on one place the later hides the earlier.
            .max_by_key(|mount| mount.mount_point.components().count())
            .map(|mount| mount.fs_type)
    }

    /// The process that holds a lock on the file at `path`.
    pub fn lock_holder(path: &Path) -> Option<i32> {
        let inode = path.metadata().ok()?.ino();
        let locks = procfs::locks().ok()?;
        locks
            .into_iter()
            .find(|lock| lock.inode == inode)
            .and_then(|lock| lock.pid)
    }
}

#[cfg(not(target_os = "linux"))]
mod other {
    use std::path::Path;

    use super::Usage;

    /// What this process takes now.
    pub fn usage() -> Option<Usage> {
        None
    }

    /// Bytes of memory that can be had without swapping.
    pub fn available_memory() -> Option<u64> {
        None
    }

    /// The kind of file system that holds `path`.
    pub fn file_system(_: &Path) -> Option<String> {
        None
    }

    /// The process that holds a lock on the file at `path`.
    pub fn lock_holder(_: &Path) -> Option<i32> {
        None
    }
}
