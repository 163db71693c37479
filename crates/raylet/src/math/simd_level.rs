//! The vector instructions of the hot loops: the widest that the processor has, or narrower ones for a comparison.

use std::sync::OnceLock;

use fearless_simd::{Level, Simd};

/// The level of the process, once it is known.
static LEVEL: OnceLock<Level> = OnceLock::new();

/// The level that all loops of the process use.
pub fn level() -> Level {
    *LEVEL.get_or_init(Level::new)
}

/// Makes all loops of the process use vector instructions of this name, `baseline` (SSE2 on x86-64), `avx2` or `avx512`,
/// before any of them has run. Benchmarks and tests compare levels with it.
///
/// # Errors
/// An unknown name, one that the processor does not have, or a process whose loops use another level already. The text says
/// which.
pub fn choose_level(name: &str) -> Result<(), String> {
    let chosen = named(name).ok_or_else(|| format!("no vector instructions `{name}` here"))?;
    let current = LEVEL.get_or_init(|| chosen);
    match is_same(*current, chosen) {
        true => Ok(()),
        false => Err(String::from("loops of this process use others already")),
    }
}

/// The level of this name, if the processor has it.
#[cfg(target_arch = "x86_64")]
fn named(name: &str) -> Option<Level> {
    match name {
        "baseline" => Some(Level::baseline()),
        "avx2" => Level::new().as_avx2().map(Simd::level),
        "avx512" => Level::new().as_avx512().map(Simd::level),
        _ => None,
    }
}

/// The level of this name, if the processor has it.
#[cfg(not(target_arch = "x86_64"))]
fn named(name: &str) -> Option<Level> {
    (name == "baseline").then(Level::baseline)
}

/// Whether two levels are the same one.
fn is_same(a: Level, b: Level) -> bool {
    std::mem::discriminant(&a) == std::mem::discriminant(&b)
}
