//! The limit on memory, which the sizes in headers must keep before any memory is taken.

use std::fmt::Display;

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
