//! Processor time and memory of this process, where the system says so in `/proc`.

use std::fs::read_to_string;

/// Ticks of the clock of `/proc` in a second.
const TICKS: f64 = 100.0;

/// Seconds of processor time that this process has used, by all its threads; zero where that is unknown.
pub fn processor_seconds() -> f64 {
    let stat = read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split(' ').collect();
    let ticks = |n: usize| fields.get(n).and_then(|word| word.parse::<f64>().ok());
    (ticks(12).unwrap_or(0.0) + ticks(13).unwrap_or(0.0)) / TICKS
}

/// Largest memory that this process has had, in MB; zero where that is unknown.
pub fn peak_megabytes() -> f64 {
    let status = read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kilobytes.unwrap_or(0.0) / 1e3
}
