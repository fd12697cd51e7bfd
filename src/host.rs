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
pub use linux::{file_system, lock_holder, memory_available, memory_total, resident_bytes, usage};
#[cfg(not(target_os = "linux"))]
pub use other::{file_system, lock_holder, memory_available, memory_total, resident_bytes, usage};

#[cfg(target_os = "linux")]
mod linux {
    use std::fs;
    use std::os::unix::fs::MetadataExt;
    use std::path::{Path, PathBuf};

    use procfs::process::Process;
    use procfs::{Current, Meminfo, ProcessCGroups, WithCurrentSystemInfo};

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

    /// Bytes of memory of this process that are in RAM. Reads one small file of `/proc`.
    pub fn resident_bytes() -> Option<u64> {
        Some(Process::myself().ok()?.stat().ok()?.rss_bytes().get())
    }

    /// Bytes of memory that this process can have: those of the machine or, when that is less, what its
    /// control groups allow.
    pub fn memory_total() -> Option<u64> {
        let machine = Meminfo::current().ok()?.mem_total;
        let groups = Process::myself().and_then(|process| process.cgroups());
        let limits = groups.ok().into_iter().flat_map(limit_files);
        let limits = limits.filter_map(|file| {
            // Version 2 writes `max` where there is no limit, version 1 an enormous number.
            fs::read_to_string(file).ok()?.trim().parse::<u64>().ok()
        });
        Some(limits.fold(machine, u64::min))
    }

    /// Bytes of memory that can be had now without swapping.
    pub fn memory_available() -> Option<u64> {
        Meminfo::current().ok()?.mem_available
    }

    /// Every file that may hold a memory limit of a process in `groups`: a group is bound by all that it
    /// lies in.
    fn limit_files(groups: ProcessCGroups) -> Vec<PathBuf> {
        let mut files = Vec::new();
        for group in groups {
            let (root, file) = match group.controllers.as_slice() {
                [] => ("/sys/fs/cgroup", "memory.max"),
                controllers if controllers.iter().any(|name| name == "memory") => {
                    ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
                }
                _ => continue,
            };
            let path = Path::new(group.pathname.trim_start_matches('/'));
            let places = path.ancestors();
            files.extend(places.map(|place| Path::new(root).join(place).join(file)));
        }
        files
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

    #[cfg(test)]
    mod tests {
        use procfs::FromRead;

        use super::*;

        #[test]
        fn groups_of_either_version_are_bound_by_those_around_them() {
            let groups = "4:cpu,memory:/a/b\n1:cpu:/c\n0::/d\n";
            let files = limit_files(ProcessCGroups::from_read(groups.as_bytes()).unwrap());
            let names: Vec<_> = files.iter().filter_map(|file| file.to_str()).collect();
            assert_eq!(
                names,
                [
                    "/sys/fs/cgroup/memory/a/b/memory.limit_in_bytes",
                    "/sys/fs/cgroup/memory/a/memory.limit_in_bytes",
                    "/sys/fs/cgroup/memory/memory.limit_in_bytes",
                    "/sys/fs/cgroup/d/memory.max",
                    "/sys/fs/cgroup/memory.max",
                ]
            );
        }

        #[test]
        fn what_the_process_takes_is_within_what_it_can_have() {
            let (taken, total) = (resident_bytes().unwrap(), memory_total().unwrap());
            assert!(taken > 1 << 20 && taken < total, "{taken} of {total}");
        }
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

    /// Bytes of memory of this process that are in RAM.
    pub fn resident_bytes() -> Option<u64> {
        None
    }

    /// Bytes of memory that this process can have.
    pub fn memory_total() -> Option<u64> {
        None
    }

    /// Bytes of memory that can be had now without swapping.
    pub fn memory_available() -> Option<u64> {
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
