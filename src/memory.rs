//! The memory that is left to this process: what the machine, its control groups and its limits leave.
//!
//! A CPU adapter and the CPU reference work in the host's memory, and systems overcommit it: an allocation
//! succeeds, and the process is killed when it is filled. So what is needed is compared with what is left before anything is
//! allocated ([`Params::memory_check`](crate::Params::memory_check)).

use crate::error::Error;
pub use crate::error::Left;
use std::path::Path;

/// The least that a limit leaves to this process: the memory and the swap that the machine has available, of each control
/// group from this process's upwards its maximum less what is in use and cannot be reclaimed, and the address space.
/// `None` where nothing is known: on other systems than Linux.
#[must_use]
pub fn left() -> Option<Left> {
    if cfg!(target_os = "linux") { left_in(Path::new("/")) } else { None }
}

/// As [`left`], for a system whose files lie below `root`.
fn left_in(root: &Path) -> Option<Left> {
    let machine = machine(root);
    let swap = machine.as_ref().map_or(0, |(_, swap)| *swap);
    let machine = machine.map(|(bytes, swap)| Left { bytes: bytes + swap, limit: "the machine".into() });
    machine.into_iter().chain(groups(root, swap)).chain(address_space(root)).min_by_key(|left| left.bytes)
}

/// Compares what is needed, beyond what is in use, with what is left.
///
/// # Errors
/// [`Error::Memory`] if less is left than `needed` bytes.
pub fn ensure(what: &str, needed: u64) -> Result<(), Error> {
    match left() {
        Some(left) if left.bytes < needed => Err(Error::Memory { what: what.into(), needed, left }),
        _ => Ok(()),
    }
}

fn number(text: &str) -> Option<u64> {
    text.split_whitespace().next()?.parse().ok()
}

fn number_in(path: &Path) -> Option<u64> {
    number(&std::fs::read_to_string(path).ok()?)
}

/// The number behind a name at the start of a line.
fn named(text: &str, name: &str) -> Option<u64> {
    text.lines().find_map(|line| number(line.strip_prefix(name)?.trim_start_matches(':')))
}

/// Memory that is available, and swap that is free.
fn machine(root: &Path) -> Option<(u64, u64)> {
    let text = std::fs::read_to_string(root.join("proc/meminfo")).ok()?;
    Some((1024 * named(&text, "MemAvailable")?, 1024 * named(&text, "SwapFree").unwrap_or(0)))
}

/// What each control group leaves, of both versions.
fn groups(root: &Path, swap: u64) -> Vec<Left> {
    let text = std::fs::read_to_string(root.join("proc/self/cgroup")).unwrap_or_default();
    let mut all = Vec::new();
    for line in text.lines() {
        let mut parts = line.splitn(3, ':');
        let (Some(_), Some(controllers), Some(path)) = (parts.next(), parts.next(), parts.next()) else { continue };
        let (mount, files) = match controllers {
            "" => ("sys/fs/cgroup", TWO),
            list if list.split(',').any(|name| name == "memory") => ("sys/fs/cgroup/memory", ONE),
            _ => continue,
        };
        // Its own and those around it, up to the mount.
        for group in Path::new(path.trim_start_matches('/')).ancestors() {
            let left = left_of(&root.join(mount).join(group), files, swap);
            let limit = format!("the control group /{}", group.display());
            all.extend(left.map(|bytes| Left { bytes, limit }));
        }
    }
    all
}

/// The names of a version: of the maximum, of what is in use, and the prefix of its statistics.
type Files = (&'static str, &'static str, &'static str);
const TWO: Files = ("memory.max", "memory.current", "");
const ONE: Files = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_");

/// The smallest maximum of version 1 that stands for no limit.
const UNLIMITED: u64 = 1 << 60;

fn left_of(group: &Path, (max, current, prefix): Files, swap: u64) -> Option<u64> {
    let max = number_in(&group.join(max)).filter(|&max| max < UNLIMITED)?;
    let used = number_in(&group.join(current))?;
    let statistics = std::fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    // Cached pages of files are reclaimed when memory is needed.
    let of = |name: &str| named(&statistics, &format!("{prefix}{name} ")).unwrap_or(0);
    let reclaimable = of("inactive_file") + of("active_file");
    let swap_max = std::fs::read_to_string(group.join("memory.swap.max")).ok();
    let swap = match swap_max.as_deref().map(number) {
        Some(Some(most)) => swap.min(most.saturating_sub(number_in(&group.join("memory.swap.current")).unwrap_or(0))),
        Some(None) => swap, // "max"
        None => 0,
    };
    Some(max.saturating_sub(used.saturating_sub(reclaimable)) + swap)
}

/// The address space less what is mapped.
fn address_space(root: &Path) -> Option<Left> {
    let limits = std::fs::read_to_string(root.join("proc/self/limits")).ok()?;
    let status = std::fs::read_to_string(root.join("proc/self/status")).ok()?;
    let most = named(&limits, "Max address space")?;
    let bytes = most.saturating_sub(1024 * named(&status, "VmSize")?);
    Some(Left { bytes, limit: "the address space of the process (ulimit -v)".into() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// A system of these files.
    struct System(PathBuf);

    impl Drop for System {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    impl System {
        fn new(files: &[(&str, &str)]) -> Self {
            static NUMBER: AtomicU32 = AtomicU32::new(0);
            let name = format!("gpu-stereo-{}-{}", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed));
            let system = Self(std::env::temp_dir().join(name));
            for (path, text) in files {
                let path = system.0.join(path);
                std::fs::create_dir_all(path.parent().unwrap()).unwrap();
                std::fs::write(path, text).unwrap();
            }
            system
        }

        fn left(&self) -> Option<(u64, String)> {
            left_in(&self.0).map(|left| (left.bytes, left.limit))
        }
    }

    const MACHINE: (&str, &str) = ("proc/meminfo", "MemTotal: 900 kB\nMemAvailable:    800 kB\nSwapFree: 8 kB\n");

    #[test]
    fn the_tightest_limit_counts() {
        assert_eq!(System::new(&[]).left(), None);
        assert_eq!(System::new(&[MACHINE]).left(), Some((808 << 10, "the machine".into())));
        let group = |more: &[(&'static str, &'static str)]| {
            let files = [MACHINE, ("proc/self/cgroup", "3:cpu:/x\n0::/jobs/7\n")];
            System::new(&[&files, more].concat()).left()
        };
        assert_eq!(group(&[]).unwrap().1, "the machine");
        let inner = [("sys/fs/cgroup/jobs/7/memory.max", "max\n"), ("sys/fs/cgroup/jobs/7/memory.current", "9\n")];
        assert_eq!(group(&inner).unwrap().1, "the machine");
        // The one around it has a maximum; what files occupy is to be had, but for what is written.
        let outer = [
            ("sys/fs/cgroup/jobs/memory.max", "500000\n"),
            ("sys/fs/cgroup/jobs/memory.current", "200000\n"),
            ("sys/fs/cgroup/jobs/memory.stat", "anon 7\nfile 9\ninactive_file 40000\nactive_file 2000\n"),
        ];
        let both = [&inner[..], &outer[..]].concat();
        assert_eq!(group(&both), Some((342_000, "the control group /jobs".into())));
        // More in use than the maximum, and swap for some of it.
        let full = [
            ("sys/fs/cgroup/jobs/7/memory.max", "100\n"),
            ("sys/fs/cgroup/jobs/7/memory.current", "300\n"),
            ("sys/fs/cgroup/jobs/7/memory.swap.max", "50\n"),
            ("sys/fs/cgroup/jobs/7/memory.swap.current", "20\n"),
        ];
        assert_eq!(group(&full), Some((30, "the control group /jobs/7".into())));
        // In a container the group may be the mount itself.
        let mounted = [("sys/fs/cgroup/memory.max", "4096"), ("sys/fs/cgroup/memory.current", "96")];
        assert_eq!(group(&mounted), Some((4000, "the control group /".into())));
    }

    #[test]
    fn the_first_version_and_the_address_space() {
        let files = [
            MACHINE,
            ("proc/self/cgroup", "9:cpu,memory:/a\n"),
            ("sys/fs/cgroup/memory/a/memory.limit_in_bytes", "9223372036854771712\n"),
            ("sys/fs/cgroup/memory/a/memory.usage_in_bytes", "1000\n"),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "5000\n"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "3000\n"),
            ("sys/fs/cgroup/memory/memory.stat", "inactive_file 1\ntotal_inactive_file 500\n"),
        ];
        assert_eq!(System::new(&files).left(), Some((2500, "the control group /".into())));
        let limits = |soft: &str| format!("Limit    Soft\nMax address space         {soft}     unlimited bytes\n");
        let (tight, none) = (limits("9216"), limits("unlimited"));
        let status = ("proc/self/status", "Name: x\nVmSize:\t      8 kB\n");
        let left = System::new(&[MACHINE, status, ("proc/self/limits", &tight)]).left().unwrap();
        assert_eq!(left.0, 1024);
        assert!(left.1.contains("ulimit -v"), "{}", left.1);
        assert_eq!(System::new(&[MACHINE, status, ("proc/self/limits", &none)]).left().unwrap().1, "the machine");
    }
}
