//! The program and the machine that a result was made by.

use serde::{Deserialize, Serialize};

/// Program and machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Version of this library.
    pub raylet: String,
    /// Operating system and processor, such as "linux x86_64".
    pub platform: String,
    /// Processors that the program may use.
    pub cpus: usize,
    /// Threads that shared the work.
    pub threads: usize,
    /// Most memory that the program held, in units of 10⁶ bytes; none where the system does not report it.
    pub peak_memory_mb: Option<f64>,
}

impl Machine {
    /// This program on this machine, now.
    pub fn here() -> Self {
        Self {
            raylet: env!("CARGO_PKG_VERSION").to_owned(),
            platform: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            cpus: std::thread::available_parallelism().map_or(1, usize::from),
            threads: rayon::current_num_threads(),
            peak_memory_mb: peak_memory_mb(),
        }
    }
}

/// Linux reports the high-water mark of the resident memory as VmHWM, in units of 1024 bytes.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kilobytes * 1.024e-3)
}
