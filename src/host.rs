//! Queries the operating system about this process, its memory and its disks; `None` where it does not say.

use std::io;
use std::path::Path;

/// The resources that this process currently uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Usage {
    /// Memory in RAM, in bytes.
    pub resident_bytes: u64,
    /// Processor time since the start, in seconds.
    pub cpu_seconds: f64,
    /// Open files, sockets and pipes.
    pub open_files: u64,
    pub threads: u64,
}

/// Returns how many bytes an unprivileged process may still write to the file system of `path`.
pub fn free_bytes(path: &Path) -> io::Result<u64> {
    let found = rustix::fs::statvfs(path)?;
    Ok(found.f_bavail.saturating_mul(found.f_frsize))
}

/// Returns how many files this process may have open once it has raised its limit; `None` is no limit.
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

    /// Returns what this process uses now. Reads a few small files of `/proc`.
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

    /// Returns the memory of this process in RAM, in bytes. Reads one small file of `/proc`.
    pub fn resident_bytes() -> Option<u64> {
        Some(Process::myself().ok()?.stat().ok()?.rss_bytes().get())
    }

    /// Returns how much memory this process can have, in bytes: that of the machine or, if less, what its control groups
    /// allow.
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

    /// Returns how much memory is available without swapping, in bytes.
    pub fn memory_available() -> Option<u64> {
        Meminfo::current().ok()?.mem_available
    }

    /// Returns every file that may hold a memory limit of a process in `groups`: the limits of all groups around a group
    /// apply to it.
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

    /// Returns the kind of file system that holds `path`, such as `ext4`.
    pub fn file_system(path: &Path) -> Option<String> {
        let path = path.canonicalize().ok()?;
        let mounts = Process::myself().ok()?.mountinfo().ok()?;
        mounts
            .into_iter()
            .filter(|mount| path.starts_with(&mount.mount_point))
            // Of two mounts at one place the later hides the earlier.
            .max_by_key(|mount| mount.mount_point.components().count())
            .map(|mount| mount.fs_type)
    }

    /// Returns the process that holds a lock on the file at `path`.
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
        fn limits_of_the_groups_around_a_group_apply_in_either_version() {
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
        fn the_process_uses_less_memory_than_it_can_have() {
            let (taken, total) = (resident_bytes().unwrap(), memory_total().unwrap());
            assert!(taken > 1 << 20 && taken < total, "{taken} of {total}");
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod other {
    use std::path::Path;

    use super::Usage;

    /// Returns what this process uses now.
    pub fn usage() -> Option<Usage> {
        None
    }

    /// Returns the memory of this process in RAM, in bytes.
    pub fn resident_bytes() -> Option<u64> {
        None
    }

    /// Returns how much memory this process can have, in bytes.
    pub fn memory_total() -> Option<u64> {
        None
    }

    /// Returns how much memory is available without swapping, in bytes.
    pub fn memory_available() -> Option<u64> {
        None
    }

    /// Returns the kind of file system that holds `path`.
    pub fn file_system(_: &Path) -> Option<String> {
        None
    }

    /// Returns the process that holds a lock on the file at `path`.
    pub fn lock_holder(_: &Path) -> Option<i32> {
        None
    }
}
