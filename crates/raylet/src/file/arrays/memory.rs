//! The limit on memory, which the sizes in headers must keep before any memory is taken.

use std::fmt::Display;

use sysinfo::System;

/// Limits are whole multiples of these bytes.
const MEGABYTE: u64 = 1_000_000;

/// The least limit in bytes where none is given.
pub(crate) const LEAST_LIMIT: u64 = MEGABYTE;

/// The limit in bytes where the machine does not report its memory.
const UNKNOWN: u64 = 4096 * MEGABYTE;

/// The memory of a machine in bytes, or of the control group in which the program runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MachineMemory {
    /// All of it; 0 if the machine does not report it.
    pub total: u64,
    /// What programs may still take now. Files that the system keeps in memory count as free.
    pub free: u64,
}

impl MachineMemory {
    /// The memory of this machine, now.
    pub fn now() -> Self {
        let mut system = System::new();
        system.refresh_memory();
        let machine = Self {
            total: system.total_memory(),
            free: system.available_memory(),
        };
        // A group without a limit reports the memory of the machine.
        let group = (machine.total > 0)
            .then(|| system.cgroup_limits())
            .flatten();
        group.map_or(machine, |group| Self {
            total: machine.total.min(group.total_memory),
            free: (machine.free).min(group.total_memory.saturating_sub(group.rss)),
        })
    }

    /// The limit on arrays where none is given, in bytes: half of what is free.
    pub fn usual_limit(&self) -> u64 {
        match self.total {
            0 => UNKNOWN,
            _ => (self.free / 2 / MEGABYTE * MEGABYTE).max(LEAST_LIMIT),
        }
    }
}

/// The most memory that arrays may take, and what sets it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLimit {
    /// In bytes.
    pub bytes: u64,
    /// The setting or the option that a message names.
    pub set_by: &'static str,
}

impl MemoryLimit {
    /// The limit of a scene's settings, or what is left of it, in bytes.
    pub fn of_settings(bytes: u64) -> Self {
        let set_by = "settings.memory_limit_mb";
        Self { bytes, set_by }
    }

    /// The limit that remains after `bytes` are taken; 0 if there are fewer.
    #[must_use]
    pub fn without(self, bytes: u64) -> Self {
        Self {
            bytes: self.bytes.saturating_sub(bytes),
            ..self
        }
    }

    /// Refuses what would take more, as (found, expected).
    pub(crate) fn check(&self, what: impl Display, bytes: u64) -> Result<(), (String, String)> {
        if bytes <= self.bytes {
            return Ok(());
        }
        let megabytes = |bytes: u64| (bytes as f64 * 1e-3).round() / 1e3;
        Err((
            format!("{what} that take {} MB", megabytes(bytes)),
            format!("at most {} MB ({})", megabytes(self.bytes), self.set_by),
        ))
    }
}

#[cfg(test)]
mod tests {
    use crate::file::arrays::memory::MachineMemory;

    #[test]
    fn the_usual_limit_is_half_of_what_is_free() {
        let limit = |total: u64, free: u64| MachineMemory { total, free }.usual_limit();
        assert_eq!(limit(16_000_000_000, 9_001_234_567), 4_500_000_000);
        assert_eq!(limit(16_000_000_000, 0), 1_000_000);
        assert_eq!(limit(0, 0), 4_096_000_000);
    }

    /// This machine has memory, and not more free than there is.
    #[test]
    fn this_machine_reports_its_memory() {
        let here = MachineMemory::now();
        assert!(
            here.total == 0 || (1..=here.total).contains(&here.free),
            "{here:?}"
        );
    }
}
