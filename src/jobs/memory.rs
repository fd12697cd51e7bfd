//! How much memory the process may take and takes.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// The bound on the memory of the process, and whether it was passed when it was last looked at.
#[derive(Debug)]
pub struct Memory {
    limit: Option<u64>,
    over: AtomicBool,
}

impl Memory {
    /// `limit` in bytes; without one nothing is bounded.
    pub fn new(limit: Option<u64>) -> Self {
        Self {
            limit,
            over: AtomicBool::new(false),
        }
    }

    /// Looks whether the process takes more than it may. Costs some 20 µs.
    pub fn look(&self) -> bool {
        let over = self
            .limit
            .is_some_and(|limit| resident().is_some_and(|taken| taken > limit));
        self.over.store(over, Ordering::Relaxed);
        over
    }

    /// What the last look found.
    pub fn is_over(&self) -> bool {
        self.over.load(Ordering::Relaxed)
    }

    pub fn limit(&self) -> Option<u64> {
        self.limit
    }
}

/// Bytes of physical memory that the process takes; `None` where the system does not tell.
///
/// From `/proc/self/status`, which counts in kilobytes; `statm` counts in pages, whose size only a
/// system call tells.
pub fn resident() -> Option<u64> {
    kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// Bytes of memory that the process can have: those of the machine or, when that is less, what its
/// control groups allow. `None` where the system does not tell.
pub fn available() -> Option<u64> {
    let machine = kilobytes(&fs::read_to_string("/proc/meminfo").ok()?, "MemTotal:")?;
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let limits = limit_files(&groups).into_iter().filter_map(|file| {
        // Version 2 writes `max` where there is no limit, version 1 an enormous number.
        fs::read_to_string(file).ok()?.trim().parse::<u64>().ok()
    });
    Some(limits.fold(machine, u64::min))
}

/// Every file that may hold a memory limit of a process whose `/proc/self/cgroup` reads `groups`: a group
/// is bound by all that it lies in.
fn limit_files(groups: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for line in groups.lines() {
        let mut pieces = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(group)) = (pieces.next(), pieces.next()) else {
            continue;
        };
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            controllers if controllers.split(',').any(|name| name == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        let group = Path::new(group.trim_start_matches('/'));
        files.extend(
            group
                .ancestors()
                .map(|at| Path::new(root).join(at).join(file)),
        );
    }
    files
}

/// The value of a line such as `MemTotal:  24684000 kB`, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let number: u64 = line.split_whitespace().next()?.parse().ok()?;
    number.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_of_either_version_are_bound_by_those_around_them() {
        let files = limit_files("4:cpu,memory:/a/b\n1:cpu:/c\n0::/d\n");
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
        assert!(limit_files("odd\n").is_empty());
    }

    #[test]
    fn lines_of_kilobytes_are_read() {
        let text = "VmPeak:\t 9 kB\nVmRSS:\t    1234 kB\n";
        assert_eq!(kilobytes(text, "VmRSS:"), Some(1234 * 1024));
        assert_eq!(kilobytes(text, "VmSwap:"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_the_process_takes_is_within_what_it_can_have() {
        let taken = resident().unwrap();
        assert!(taken > 1 << 20 && taken < available().unwrap(), "{taken}");
    }
}
